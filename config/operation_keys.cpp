#include <algorithm>
#include <map>

#include "config/job.h"
#include "config/job_catalogue.h"
#include "config/job_reading.h"
#include "config/operations.h"
#include "config/text_layout.h"

namespace tiltfeed::config {
namespace {

constexpr const char* kOperations = "operations";

/// "cutter" of "cutter.type"; of the section program the whole path, since it is taken key by key.
std::string owner_of(const std::string& path) {
  if (path.starts_with("program.")) return path;
  return path.substr(0, path.find_first_of(".["));
}

/// The operation's own sections and keys.
std::vector<std::string> own_of(const YamlNode& operation) {
  std::vector<std::string> own;
  for (std::size_t i = 0; i < operation.keys.size(); ++i) {
    const std::string& key = operation.keys[i].text;
    if (key == "name") continue;
    if (key != "program") own.push_back(key);
    if (key == "program")
      for (const YamlKey& inner : operation.items[i].keys) own.push_back("program." + inner.text);
  }
  return own;
}

}  // namespace

Result<KeyLog> job_keys(const std::string& text) {
  const Result<YamlNode> tree = parse_yaml(text, "job");
  if (!tree) return tl::unexpected(tree.error());
  KeyLog log;
  Complaint complaint("job", &log);
  const Section root = job_root(*tree, complaint);
  read_job(root, "job", nullptr);
  operation_trees(*tree, root);
  reads_by_tool(root);
  return log;
}

bool OperationKeys::has_own(const std::string& path) const {
  return std::find(own.begin(), own.end(), owner_of(path)) != own.end();
}

std::string OperationKeys::place(const std::string& path) const {
  return has_own(path) ? std::string(kOperations) + "[" + std::to_string(number) + "]." + path : path;
}

Result<std::vector<OperationKeys>> operation_keys(const std::string& text) {
  const Result<YamlNode> tree = parse_yaml(text, "job");
  if (!tree) return tl::unexpected(tree.error());
  Complaint complaint("job");
  const Section root = job_root(*tree, complaint);
  const std::vector<OperationTree> trees = operation_trees(*tree, root);
  const auto list = key_index(*tree, kOperations);
  std::vector<OperationKeys> all;
  for (std::size_t i = 0; i < trees.size(); ++i) {
    OperationKeys& one = all.emplace_back();
    if (list) one = {trees[i].name, i + 1, own_of(tree->items[*list].items[i]), {}};
    Complaint own("job", &one.log);
    read_job(job_root(trees[i].tree, own), "job", nullptr);
  }
  return all;
}

Result<std::vector<std::string>> unused_keys(const std::string& text) {
  const Result<KeyLog> shared = job_keys(text);
  if (!shared) return tl::unexpected(shared.error());
  const auto operations = operation_keys(text);
  if (!operations) return tl::unexpected(operations.error());
  std::vector<std::string> paths;
  for (const KeyFact& fact : shared->facts())
    if (fact.path == "operation_order" && fact.present && !fact.unused.empty()) paths.push_back(fact.path);
  // What stands for several counts for one of them.
  std::map<std::string, bool> counts;
  for (const OperationKeys& one : *operations)
    for (const KeyFact& fact : one.log.facts())
      if (fact.present) counts[one.place(fact.path)] |= fact.unused.empty();
  for (const auto& [path, is] : counts)
    if (!is) paths.push_back(path);
  return paths;
}

Result<KeyOrder> key_order(const std::string& text) {
  const Result<KeyLog> log = job_keys(text);
  if (!log) return tl::unexpected(log.error());
  return KeyOrder([log = *log](const std::string& section) {
    std::vector<std::string> known = log.known(section);
    const std::size_t inner = section.starts_with("operations[") ? section.find("].") : section.npos;
    return known.empty() && inner != section.npos ? log.known(section.substr(inner + 2)) : known;
  });
}

}  // namespace tiltfeed::config
