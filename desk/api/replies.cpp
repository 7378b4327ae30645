#include "desk/api/replies.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace tiltfeed::desk {

using nlohmann::json;

namespace {

constexpr std::size_t kMaxName = 120;

}  // namespace

Reply text_reply(std::string body, int status) {
  Reply reply;
  reply.status = status;
  reply.body = std::move(body) + "\n";
  return reply;
}

std::optional<std::string> text_in(const std::string& body, const char* key) {
  const json parsed = json::parse(body, nullptr, false);
  if (!parsed.is_object()) return std::nullopt;
  const auto found = parsed.find(key);
  if (found == parsed.end() || !found->is_string()) return std::nullopt;
  return found->get<std::string>();
}

Reply refused_by(const Error& error) {
  return refusal(error.code == Code::kUsage ? 409 : error.code == Code::kInput ? 400 : 507, error.message);
}

std::string shown_name(std::string name, const char* otherwise) {
  name.erase(0, name.find_last_of("/\\") + 1);
  name.resize(std::min(name.size(), kMaxName));
  std::erase_if(name, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
  return name.empty() ? otherwise : name;
}

}  // namespace tiltfeed::desk
