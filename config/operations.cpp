#include "config/operations.h"

#include <algorithm>
#include <set>

namespace tiltfeed::config {
namespace {

const char* const kList = "operations";
const char* const kProgram = "program";

YamlNode* value_of(YamlNode& map, const std::string& key) {
  const auto found =
      std::find_if(map.keys.begin(), map.keys.end(), [&](const YamlKey& one) { return one.text == key; });
  return found == map.keys.end() ? nullptr : &map.items[static_cast<std::size_t>(found - map.keys.begin())];
}

void put(YamlNode& map, const YamlKey& key, const YamlNode& value) {
  if (YamlNode* there = value_of(map, key.text))
    *there = value;
  else
    map.keys.push_back(key), map.items.push_back(value);
}

void take_out(YamlNode& map, const std::string& key) {
  const YamlNode* there = value_of(map, key);
  if (there == nullptr) return;
  const auto index = there - map.items.data();
  map.keys.erase(map.keys.begin() + index);
  map.items.erase(map.items.begin() + index);
}

/// The job's shared part with what the operation states.
YamlNode merged(const YamlNode& shared, const YamlNode& operation) {
  YamlNode job = shared;
  job.place = operation.place;  // a section that both lack is missing in the operation
  for (std::size_t i = 0; i < operation.keys.size(); ++i) {
    const YamlKey& key = operation.keys[i];
    const YamlNode& value = operation.items[i];
    if (key.text == "name") continue;
    YamlNode* const program = key.text == kProgram ? value_of(job, kProgram) : nullptr;
    if (program == nullptr || program->kind != YamlKind::kMap || value.kind != YamlKind::kMap) {
      put(job, key, value);
      continue;
    }
    program->place = value.place;
    for (std::size_t k = 0; k < value.keys.size(); ++k) put(*program, value.keys[k], value.items[k]);
  }
  return job;
}

}  // namespace

std::vector<OperationTree> operation_trees(const YamlNode& tree, const Section& root) {
  const std::vector<Section> list =
      root.list(kList,
                {"name", "cutter", "axis", "pattern", "rest", "containment", "tolerance_mm", "allowance_mm",
                 "stock", "points", "guards", "links", "clearance_mm", "approach_mm", "feeds", kProgram},
                kMostOperations);
  if (!root.has(kList)) return {{"", tree}};
  YamlNode shared = tree;
  const YamlNode operations = *value_of(shared, kList);
  take_out(shared, kList);
  take_out(shared, "operation_order");
  std::vector<OperationTree> trees;
  std::set<std::string> names;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string name = list[i].name("name");
    if (list[i].sound("name") && !names.insert(name).second)
      list[i].complain("name", "two operations have this name; each needs its own");
    if (list[i].has(kProgram))  // what the whole program has is the job's own
      list[i].section(kProgram,
                      {"tool", "length_register", "coolant", "smoothing", "smoothing_tolerance_mm"});
    trees.push_back({name, merged(shared, operations.items[i])});
  }
  return trees;
}

}  // namespace tiltfeed::config
