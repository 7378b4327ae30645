#include "daemon/command/mtconnect_command.h"

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <mutex>
#include <optional>
#include <thread>

#include "config/service_config.h"
#include "daemon/command/command.h"
#include "daemon/command/interrupt.h"
#include "daemon/mtconnect/adapter.h"
#include "daemon/mtconnect/service_watch.h"

namespace tiltfeed::daemon {
namespace {

constexpr std::chrono::milliseconds kServe{50}, kRunPeriod{200}, kIdlePeriod{1000};

/// The newest view, from the thread that asks for it.
struct Newest {
  std::mutex lock;
  bool fresh = false;
  std::optional<ServiceView> view;
};

void watch(const std::stop_token& end, const std::string& socket, Newest& newest) {
  ServiceWatch service(socket);
  while (!end.stop_requested()) {
    auto view = service.look();
    {
      const std::lock_guard hold(newest.lock);
      newest.view = std::move(view);
      newest.fresh = true;
    }
    const auto next = std::chrono::steady_clock::now() + (service.runs() ? kRunPeriod : kIdlePeriod);
    while (!end.stop_requested() && std::chrono::steady_clock::now() < next)
      std::this_thread::sleep_for(kServe);
  }
}

}  // namespace

struct MtconnectCommand::Options {
  CLI::App* mtconnect = nullptr;
  std::string version, config, listen = "127.0.0.1:7878", device_file;
};

MtconnectCommand::MtconnectCommand(CLI::App& app, const std::string& version)
    : options_(std::make_unique<Options>()) {
  Options& o = *options_;
  o.version = version;
  o.mtconnect =
      app.add_subcommand("mtconnect", "adapter for MTConnect agents: tells them of a service's machine");
  o.mtconnect->add_option("--config", o.config, "the service's file (YAML)")->required();
  o.mtconnect->add_option("--listen", o.listen, "HOST:PORT where agents connect")->capture_default_str();
  o.mtconnect->add_option("--device-file", o.device_file,
                          "only write the agent's Devices.xml for the service's machine (- shows it)");
}

MtconnectCommand::~MtconnectCommand() = default;

bool MtconnectCommand::called() const { return options_->mtconnect->parsed(); }

int MtconnectCommand::run() const {
  const Options& o = *options_;
  const Result<config::ServiceConfig> service = config::load_service_config(o.config);
  if (!service) return complain(service.error());
  if (!o.device_file.empty()) {
    // As the shop's page has it: /etc/tiltfeed/NAME.yaml is the service of the machine NAME.
    const std::string stem = std::filesystem::path(o.config).stem().string();
    const std::string text = device_file(service->machine.model, stem == "service" ? "" : stem);
    return give_text(text, o.device_file, false);
  }
  const std::vector<DataItem> items = data_items(service->machine.model);
  hear_interrupts();
  Result<Adapter> adapter = Adapter::open(o.listen, items, o.version);
  if (!adapter) return complain(adapter.error());
  std::cout << "ready on " << adapter->address() << std::endl;
  Newest newest;
  const std::jthread asking([&](const std::stop_token& end) { watch(end, service->socket, newest); });
  while (!interrupted()) {
    adapter->serve(kServe);
    const std::lock_guard hold(newest.lock);
    if (!newest.fresh) continue;
    newest.fresh = false;
    const Result<Observations> now = observe(items, newest.view);
    if (!now) return complain(now.error());
    adapter->tell(*now);
  }
  return kExitDone;
}

}  // namespace tiltfeed::daemon
