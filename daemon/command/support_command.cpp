#include "daemon/command/support_command.h"

#include <sys/utsname.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <ctime>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "config/service_config.h"
#include "daemon/command/command.h"
#include "daemon/command/doctor_command.h"
#include "daemon/command/history_command.h"
#include "daemon/doctor/support_text.h"
#include "daemon/metrics/metrics.h"

namespace tiltfeed::daemon {

namespace {

using nlohmann::json;

constexpr std::size_t kRuns = 200, kJobs = 5, kMostOfFile = 64 << 10, kMostOfProfile = 1 << 20;
constexpr const char* kLogLines = "2000";

std::string computer() {
  utsname name{};
  ::uname(&name);
  return std::string(name.sysname) + " " + name.release + " " + name.machine + "\n" +
         tail_of_file("/etc/os-release", kMostOfFile);
}

/// Of the units that are started from this file's name, where systemd runs.
std::string log_of_units(const std::string& config) {
  std::error_code none;
  if (!std::filesystem::exists("/run/systemd/system", none)) return "systemd does not run here";
  const std::string name = std::filesystem::path(config).stem().string();
  const std::string text =
      output_of("/usr/bin/journalctl", {"--unit=tiltfeed@" + name, "--unit=tiltfeed-desk@" + name,
                                        "--unit=tiltfeed-mtconnect@" + name, "--lines", kLogLines,
                                        "--no-pager", "--output=short-iso"});
  return text.empty() ? "journalctl tells nothing; run this as root, or as one of the group systemd-journal"
                      : text;
}

std::string runs_of(const std::string& socket) {
  const Result<std::string> runs = last_runs(socket, kRuns);
  if (!runs) return runs.error().message;
  return runs->empty() ? "no runs" : *runs;
}

/// A job a line, so that it can be read before it is sent.
std::string lines_of(const std::string& answer) {
  nlohmann::ordered_json read = nlohmann::ordered_json::parse(answer, nullptr, false);
  if (!read.is_object() || !read.contains("jobs")) return answer + "\n";
  const nlohmann::ordered_json jobs = std::move(read["jobs"]);
  read.erase("jobs");
  std::string text = read.dump() + "\n";
  for (const nlohmann::ordered_json& job : jobs) text += job.dump() + "\n";
  return text;
}

/// Of the last jobs that ended badly or wait for an operator: how their planning ended, the last lines on the
/// wire.
std::string troubles(const std::vector<std::string>& answers, const std::string& spool) {
  std::vector<json> jobs;
  for (const std::string& answer : answers) {
    const json read = json::parse(answer, nullptr, false);
    if (!read.is_object() || !read.contains("jobs")) continue;
    for (const json& job : read.at("jobs"))
      for (const char* const bad : {"failed", "uncertain", "interrupted", "stopped"})
        if (job.value("state", "") == bad) jobs.push_back(job);
  }
  std::string text;
  for (std::size_t i = jobs.size() - std::min(jobs.size(), kJobs); i < jobs.size(); ++i) {
    const std::string number = std::to_string(jobs[i].value("job", std::uint64_t{0}));
    for (const char* const name : {"plan.log", "blackbox.txt"}) {
      const std::string file = spool + "/jobs/" + number + "/" + name;
      std::error_code failed;
      if (!std::filesystem::exists(file, failed) && !failed) continue;
      text += support_section("job " + number + ", " + jobs[i].value("state", "") + ": " + file,
                              tail_of_file(file, kMostOfFile));
    }
  }
  return text;
}

}  // namespace

struct SupportCommand::Options {
  CLI::App* support = nullptr;
  std::string config, version, out = "-";
  bool as_json = false;

  std::string text() const;
};

SupportCommand::SupportCommand(CLI::App& app, const std::string& version)
    : options_(std::make_unique<Options>()) {
  Options& o = *options_;
  o.version = version;
  o.support = app.add_subcommand("support-bundle",
                                 "what somebody needs who is to help, in one text without passwords");
  o.support->add_option("--config", o.config, "the service's file (YAML)")->required();
  o.support->add_option("--out", o.out, "file to write; else shown");
  o.support->add_flag("--json", o.as_json, "print one JSON object, which has the text");
}

SupportCommand::~SupportCommand() = default;

bool SupportCommand::called() const { return options_->support->parsed(); }

std::string SupportCommand::Options::text() const {
  std::string all = "tiltfeed support bundle, made " + utc_text(std::time(nullptr)) + " by tiltfeed " +
                    version +
                    "\nRead it before you send it. Passwords, tokens and sign-in codes are masked; names of "
                    "jobs, users and addresses are not.\n\n";
  all += support_section("this computer", computer());
  all += support_section("doctor", findings_text(examine(config, version, false)));
  all += support_section("the service's file: " + config, tail_of_file(config, kMostOfFile));
  const Result<config::ServiceConfig> service = config::load_service_config(config);
  if (!service) return all + support_section("its log", log_of_units(config));
  all += support_section("the machine's profile: " + service->machine.path,
                         tail_of_file(service->machine.path, kMostOfProfile));
  const std::vector<std::string> answers = all_answers(service->socket);
  std::string list = answers.empty() ? "no service answers at " + service->socket : "";
  for (const std::string& answer : answers) list += lines_of(answer);
  all += support_section("its jobs", list);
  if (!answers.empty()) all += support_section("its last runs", runs_of(service->socket));
  all += troubles(answers, service->spool);
  return all + support_section("its log", log_of_units(config));
}

int SupportCommand::run() const { return give_text(options_->text(), options_->out, options_->as_json); }

}  // namespace tiltfeed::daemon
