#include "daemon/command/doctor_command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "config/beside_program.h"
#include "daemon/command/command.h"
#include "daemon/command/machine_command.h"
#include "daemon/doctor/doctor.h"

namespace tiltfeed::daemon {

namespace {

using nlohmann::ordered_json;
constexpr int kVerdictWidth = 9, kWhatWidth = 14;

Result<LinkSpec> link_of(const config::ServiceConfig& service) {
  return parse_link(service.link, service.machine.wire, &service.machine.model);
}

/// Key and value, in the order in which they are shown.
ordered_json resolved(const config::ServiceConfig& service, const LinkSpec& link) {
  return {{"machine", service.machine.model.name},
          {"profile", service.machine.path},
          {"link", describe(link)},
          {"spool", service.spool},
          {"socket", service.socket},
          {"watch", service.watch},
          {"queue", config::shown_queue(service.queue.url)}};
}

/// The machine's own status: no command that moves anything.
Finding controller(const config::ServiceConfig& service, const LinkSpec& link, bool open) {
  if (!open)
    return {Verdict::kNotAsked, "controller",
            "--open asks it over " + describe(link) + "; opening a serial line may reset a board"};
  const Result<MachineAnswer> said = act_over(link, service.machine, "status", {});
  if (!said) return {Verdict::kToDo, "controller", said.error().message};
  return {Verdict::kGood, "controller", said->text.substr(0, said->text.find('\n'))};
}

}  // namespace

int check_service(const std::string& config, bool as_json) {
  const Result<config::ServiceConfig> service = config::load_service_config(config);
  if (!service) return complain(service.error());
  const Result<LinkSpec> link = link_of(*service);
  if (!link) return complain(link.error());
  const ordered_json object = resolved(*service, *link);
  if (as_json) return show_json(object.dump(-1, ' ', true, ordered_json::error_handler_t::replace));
  for (const auto& [key, value] : object.items())
    std::cout << key << ": " << value.get<std::string>() << "\n";
  return kExitDone;
}

Findings examine(const std::string& config, const std::string& version, bool open) {
  const Result<std::string> self = config::program_beside("tiltfeed");
  const Host host{"", self ? std::filesystem::path(*self).parent_path().string() : "", service_user(),
                  host_clock()};
  Findings found = examine_host(host, version);
  const auto add = [&](Findings more) {
    for (Finding& one : more) found.push_back(std::move(one));
  };
  if (config.empty()) return found;
  const Result<config::ServiceConfig> service = config::load_service_config(config);
  const Result<LinkSpec> link = service ? link_of(*service) : tl::unexpected<Error>(service.error());
  if (!link) return add({{Verdict::kToDo, "configuration", link.error().message}}), found;
  add({{Verdict::kGood, "configuration",
        config + ": " + service->machine.model.name + " over " + describe(*link)}});
  if (!link->over_network()) add(examine_device(host, link->place));
  add(examine_places(host, *service));
  add({controller(*service, *link, open)});
  return found;
}

std::string findings_text(const Findings& findings) {
  std::ostringstream out;
  for (const Finding& one : findings)
    out << std::left << std::setw(kVerdictWidth) << verdict_name(one.verdict) << "  " << std::setw(kWhatWidth)
        << one.what << "  " << one.text << "\n";
  return out.str();
}

struct DoctorCommand::Options {
  CLI::App* doctor = nullptr;
  std::string config, version;
  bool open = false, as_json = false;
};

DoctorCommand::DoctorCommand(CLI::App& app, const std::string& version)
    : options_(std::make_unique<Options>()) {
  Options& o = *options_;
  o.version = version;
  o.doctor = app.add_subcommand(
      "doctor", "what stands between a service and its machine: each line good, or what to do");
  o.doctor->add_option("--config", o.config, "the service's file (YAML); else this computer alone");
  o.doctor->add_flag("--open", o.open,
                     "open the line, too, and ask the controller for its status; nothing moves, but opening "
                     "a serial line may reset a board");
  o.doctor->add_flag("--json", o.as_json, "print one JSON object");
}

DoctorCommand::~DoctorCommand() = default;

bool DoctorCommand::called() const { return options_->doctor->parsed(); }

int DoctorCommand::run() const {
  const Findings found = examine(options_->config, options_->version, options_->open);
  const bool good = std::none_of(found.begin(), found.end(),
                                 [](const Finding& one) { return one.verdict == Verdict::kToDo; });
  if (options_->as_json) {
    ordered_json object = {{"good", good}, {"findings", ordered_json::array()}};
    for (const Finding& one : found)
      object["findings"].push_back(
          {{"what", one.what}, {"verdict", verdict_name(one.verdict)}, {"text", one.text}});
    show_json(object.dump(-1, ' ', true, ordered_json::error_handler_t::replace));
  } else {
    std::cout << findings_text(found);
  }
  return good ? kExitDone : kExitFailed;
}

}  // namespace tiltfeed::daemon
