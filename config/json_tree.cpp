#include "config/json_tree.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace tiltfeed::config {
namespace {

constexpr int kMostLevels = 64;

/// False where it is nested too deep.
bool convert(const nlohmann::ordered_json& from, JsonNode& to, int levels) {
  if (levels == 0) return false;
  if (from.is_boolean()) to.kind = JsonKind::kFlag, to.number = from.get<bool>() ? 1.0 : 0.0;
  if (from.is_number()) to.kind = JsonKind::kNumber, to.number = from.get<double>();
  if (from.is_string()) to.kind = JsonKind::kText, to.text = from.get<std::string>();
  if (from.is_array()) {
    to.kind = JsonKind::kList;
    for (const auto& item : from)
      if (!convert(item, to.items.emplace_back(), levels - 1)) return false;
  }
  if (from.is_object()) {
    to.kind = JsonKind::kMap;
    for (const auto& [key, value] : from.items()) {
      to.keys.push_back(key);
      if (!convert(value, to.items.emplace_back(), levels - 1)) return false;
    }
  }
  return true;
}

}  // namespace

std::string one_line(const std::string& text) {
  std::string line;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    line += byte < 0x20 || byte == 0x7F ? ' ' : c;
  }
  const std::size_t from = line.find_first_not_of(' ');
  return from == line.npos ? "" : line.substr(from, line.find_last_not_of(' ') - from + 1);
}

const JsonNode* JsonNode::find(const std::string& key) const {
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (keys[i] == key) {
      items[i].asked = true;
      return &items[i];
    }
  return nullptr;
}

std::string JsonNode::text_at(const std::string& key) const {
  const JsonNode* node = find(key);
  return node != nullptr && node->kind == JsonKind::kText ? one_line(node->text) : "";
}

double JsonNode::number_at(const std::string& key) const {
  const JsonNode* node = find(key);
  return node != nullptr && node->kind == JsonKind::kNumber && std::isfinite(node->number) ? node->number
                                                                                           : 0.0;
}

void JsonNode::pass_over() const {
  asked = true;
  for (const JsonNode& item : items) item.pass_over();
}

void JsonNode::count_unasked(const std::string& path, std::map<std::string, int>& counts) const {
  for (std::size_t i = 0; i < items.size(); ++i) {
    const std::string name = keys.empty() ? path : path.empty() ? keys[i] : path + "." + keys[i];
    items[i].count_unasked(name, counts);
  }
  if (!asked && items.empty() && (number != 0.0 || !text.empty())) ++counts[path];
}

Result<JsonNode> parse_json(const std::string& text, const std::string& file) {
  JsonNode root;
  try {
    const auto json = nlohmann::ordered_json::parse(text);
    if (!convert(json, root, kMostLevels))
      return fail(Code::kInput,
                  file + ": lists and maps over " + std::to_string(kMostLevels) + " levels deep");
  } catch (const nlohmann::json::exception& error) {
    const std::string what = error.what();
    const std::size_t at = what.find("at line");
    return fail(Code::kInput, file + ": no JSON " + one_line(at == what.npos ? what : what.substr(at)));
  }
  return root;
}

}  // namespace tiltfeed::config
