#include "config/service_config.h"

#include <filesystem>

#include "config/section.h"
#include "config/yaml_tree.h"

namespace tiltfeed::config {

namespace {

constexpr int kMostDays = 36500, kMostMib = 1 << 30;

}  // namespace

Result<ServiceConfig> parse_service_config(const std::string& text, const std::string& path) {
  const Result<YamlNode> tree = parse_yaml(text, path);
  if (!tree) return tl::unexpected(tree.error());
  Complaint complaint(path);
  const Section root(
      *tree, "",
      {"machine", "link", "spool", "socket", "watch", "queue", "queue_ahead", "plan_for_others", "retention"},
      complaint);
  const auto resolved = [&](const std::string& name) {
    return (std::filesystem::path(path).parent_path() / name).lexically_normal().string();
  };
  ServiceConfig config;
  config.path = path;
  config.machine.path = resolved(root.text("machine"));
  config.link = root.text("link", "");
  config.spool = resolved(root.text("spool"));
  config.socket = resolved(root.text("socket"));
  const std::string watch = root.text("watch", "");
  if (!watch.empty()) config.watch = resolved(watch);
  config.queue = read_queue(root);
  const Section retention = root.optional_section("retention", {"days", "mib", "history_days"});
  config.retention = {retention.integer("days", 0, kMostDays, 0), retention.integer("mib", 0, kMostMib, 0),
                      retention.integer("history_days", 0, kMostDays, 0)};
  if (complaint.error()) return tl::unexpected(*complaint.error());
  Result<MachineProfile> machine = load_named_machine(config.machine.path, root, complaint);
  if (!machine) return tl::unexpected(machine.error());
  config.machine = std::move(*machine);
  if (config.link.empty()) config.link = config.machine.link;
  if (config.link.empty()) root.complain("link", "is missing, and the machine profile has no link.default");
  if (complaint.error()) return tl::unexpected(*complaint.error());
  return config;
}

Result<ServiceConfig> load_service_config(const std::string& path) {
  const Result<std::string> text = read_config_text(path);
  if (!text) return tl::unexpected(text.error());
  return parse_service_config(*text, path);
}

}  // namespace tiltfeed::config
