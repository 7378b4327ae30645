#pragma once
// A serial line in made-up time between a session and a simulated controller: bytes take their time on the
// wire, a fault script spoils them. What the host said is kept.

#include <algorithm>
#include <string>
#include <utility>

#include "daemon/wire/link.h"
#include "sim/controller/drip_controller.h"
#include "sim/controller/grbl_controller.h"
#include "sim/controller/reprap_controller.h"
#include "sim/wire/faulty_line.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;

inline void perform_alarm(sim::GrblController& controller) { controller.raise_alarm(1); }
inline void perform_alarm(sim::RepRapController& controller) { controller.halt(); }
inline void perform_alarm(sim::DripController& controller) { controller.raise_alarm(85); }
inline void perform_reset(sim::GrblController& controller) { controller.receive("\x18"); }
inline void perform_reset(sim::RepRapController& controller) { controller.reset(); }
inline void perform_reset(sim::DripController& controller) { controller.reset(); }

template <class Controller>
class VirtualLine : public Link, public Clock {
 public:
  VirtualLine(Controller& machine, const sim::FaultScript& script, double byte_time)
      : controller(machine), line(script), byte_time_(byte_time) {}

  Time now() override { return std::chrono::duration_cast<Time>(std::chrono::duration<double>(time)); }

  Result<std::size_t> exchange(std::string_view out, Time wait, std::string& in) override {
    if (std::exchange(lost_, false)) return hung_up();
    const double end = time + std::max(std::chrono::duration<double>(wait).count(), kStep);
    const std::size_t room = kSystemBuffer - std::min(kSystemBuffer, queued_.size());
    const std::size_t taken = std::min({out.size(), room, line.slow_read() ? std::size_t{3} : room});
    queued_ += out.substr(0, taken);
    said += out.substr(0, taken);
    const std::size_t before = in.size();
    do {
      step();
      in += line.at_host(time);
    } while (time < end && in.size() == before && !(taken > 0 && !out.empty() && taken < out.size()));
    if (line.away(time)) {
      queued_.clear();
      if (taken == 0 && in.size() == before) return hung_up();
      lost_ = true;  // what was taken counts
    }
    return taken;
  }

  Controller& controller;
  sim::FaultyLine line;
  double time = 0.0;
  double latency = 0.0;  ///< of the adapter, s: what the controller says is read so much later
  std::string said;      ///< everything that the host gave to the wire

 private:
  static constexpr double kStep = 0.0005;
  static constexpr std::size_t kSystemBuffer = 4096;

  /// As many bytes as the wire carries in kStep, both ways.
  void step() {
    time += kStep;
    credit_ = std::min(credit_ + kStep, 64 * byte_time_ + kStep);
    const auto count = std::min(queued_.size(), static_cast<std::size_t>(credit_ / byte_time_));
    if (count > 0) {
      line.to_machine(std::string_view(queued_).substr(0, count), time);
      queued_.erase(0, count);
      credit_ -= static_cast<double>(count) * byte_time_;
    }
    if (line.reset_due(time)) perform_reset(controller);
    if (line.alarm_due(time)) perform_alarm(controller);
    controller.receive(line.at_machine(time));
    controller.advance(time);
    if (controller.has_output()) line.to_host(controller.take_output(), time + latency);
  }

  static tl::unexpected<Error> hung_up() {
    return fail(Code::kLink, "/dev/ttyUSB0: connection lost: the port has hung up");
  }

  double byte_time_, credit_ = 0.0;
  bool lost_ = false;
  std::string queued_;
};

}  // namespace tiltfeed
