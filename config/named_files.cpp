#include "config/named_files.h"

namespace tiltfeed::config {
namespace {

/// The value of a key of a map; null where it has none.
const YamlNode* value_at(const YamlNode* map, const char* key) {
  if (map == nullptr || map->kind != YamlKind::kMap) return nullptr;
  for (std::size_t i = 0; i < map->keys.size(); ++i)
    if (map->keys[i].text == key) return &map->items[i];
  return nullptr;
}

}  // namespace

std::vector<NamedFileKey> files_named_in(const YamlNode& job) {
  std::vector<NamedFileKey> found;
  const auto add = [&](const std::string& in, const YamlNode* map, const char* key) {
    if (const YamlNode* node = value_at(map, key)) found.push_back({in + key, node});
  };
  const auto each = [&](const char* list, auto&& look) {
    const YamlNode* items = value_at(&job, list);
    if (items == nullptr || items->kind != YamlKind::kList) return;
    for (std::size_t i = 0; i < items->items.size(); ++i)
      look(std::string(list) + "[" + std::to_string(i + 1) + "].", &items->items[i]);
  };
  add("cutter.", value_at(&job, "cutter"), "library");
  each("operations", [&](const std::string& in, const YamlNode* one) {
    add(in + "cutter.", value_at(one, "cutter"), "library");
  });
  each("fixtures", [&](const std::string& in, const YamlNode* one) { add(in, one, "stl"); });
  add("blank.", value_at(&job, "blank"), "file");
  return found;
}

}  // namespace tiltfeed::config
