#include "daemon/command/metrics_command.h"

#include <CLI/CLI.hpp>
#include <filesystem>

#include "config/service_config.h"
#include "daemon/command/command.h"
#include "daemon/metrics/metrics.h"

namespace tiltfeed::daemon {

struct MetricsCommand::Options {
  CLI::App* metrics = nullptr;
  std::string version, config, out = "-";
  bool as_json = false;
};

MetricsCommand::MetricsCommand(CLI::App& app, const std::string& version)
    : options_(std::make_unique<Options>()) {
  Options& o = *options_;
  o.version = version;
  o.metrics = app.add_subcommand("metrics", "figures of a service in the text format of Prometheus");
  o.metrics->add_option("--config", o.config, "the service's file (YAML)")->required();
  o.metrics->add_option("--out", o.out, "file to write, as a textfile of node_exporter; else shown");
  o.metrics->add_flag("--json", o.as_json, "print one JSON object, which has the text");
}

MetricsCommand::~MetricsCommand() = default;

bool MetricsCommand::called() const { return options_->metrics->parsed(); }

int MetricsCommand::run() const {
  const Options& o = *options_;
  const Result<config::ServiceConfig> service = config::load_service_config(o.config);
  if (!service) return complain(service.error());
  std::error_code error;
  const std::filesystem::space_info disk = std::filesystem::space(service->spool, error);
  if (error) return complain({Code::kIo, service->spool + ": " + error.message()});
  const Result<std::string> text =
      metrics_text(all_answers(service->socket), o.version, {disk.available, disk.capacity});
  if (!text) return complain(text.error());
  return give_text(*text, o.out, o.as_json);
}

}  // namespace tiltfeed::daemon
