#pragma once
// A shop with one machine of the Grbl family and the commands of its operator, in made-up time.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "daemon/machine/machine_orders.h"
#include "tests/peers/virtual_line.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;

inline MachineModel shop_machine() {
  MachineModel machine;
  machine.name = "shop";
  for (LinearAxis* axis : {&machine.x, &machine.y, &machine.z}) *axis = {-300, 200, 6000, 500};
  machine.tilt = {'A', {1, 0, 0}, +1, 0, -110, 110, 3600, 500};
  machine.rotary = {'C', {0, 0, 1}, -1, 0, -36000, 36000, 3600, 500};
  machine.pivot_to_gauge = {0, 0, -150};
  return machine;
}

struct OperatorShop {
  explicit OperatorShop(const sim::GrblOptions& options = {})
      : controller(shop_machine(), {}, options, [this](const sim::TraceRow& row) { rows.push_back(row); }) {
    profile.model = shop_machine();
  }

  /// The answer's text, or what went wrong.
  std::string say(const std::string& name, const std::vector<std::string>& words = {}) {
    const auto answer = ask(name, words);
    return answer ? answer->text : answer.error().message;
  }
  Result<MachineAnswer> ask(const std::string& name, const std::vector<std::string>& words = {}) {
    return perform_order(bench, name, words);
  }
  nlohmann::json json(const std::string& name, const std::vector<std::string>& words = {}) {
    const auto answer = ask(name, words);
    return answer ? nlohmann::json::parse(answer->json) : nlohmann::json(answer.error().message);
  }
  /// Somebody else's bytes, and time; what the controller says to them.
  std::string wire(const std::string& bytes, double seconds) {
    controller.receive(bytes);
    const double end = line.time + seconds;
    std::string in;
    while (line.time < end) static_cast<void>(line.exchange({}, std::chrono::milliseconds(10), in));
    return in;
  }
  Joints at() const { return controller.motion().position(); }
  /// What was sent of lines, without `?`.
  bool sent(const std::string& text) const { return line.said.find(text) != std::string::npos; }

  std::vector<sim::TraceRow> rows;
  sim::GrblController controller;
  VirtualLine<sim::GrblController> line{controller, {}, 10.0 / 115200};
  MachineProfile profile;
  LinkSpec link = *parse_link("grbl:/dev/null@115200");
  MachineBench bench{profile, link, line, line};
};

}  // namespace tiltfeed
