#pragma once
// Real time to simulated time: paced, or as fast as the host keeps up.

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>

#include "sim/motion/motion.h"
#include "sim/wire/fault_script.h"

namespace tiltfeed::sim {

struct EndpointOptions {
  double speed = 0.0;       ///< simulated seconds per real second; 0: as fast as possible
  bool once = false;        ///< leave when a program has ended and the host has nothing more to say
  double byte_time = 0.0;   ///< s of a byte on the serial line; 0: as fast as the system
  FaultScript faults = {};  ///< what goes wrong on the wire
  int stop_fd = -1;         ///< leave when this becomes readable; -1: never
  std::function<void()> flush = [] {};  ///< now and then, when there may be something to write out
  std::function<void(std::size_t bytes, double use)> line =
      {};  ///< at the end: bytes from the host, use of the line
  std::function<void(const std::string& where)> ready = [](const std::string&) {};  ///< the host may connect
};

class SimClock {
 public:
  explicit SimClock(double speed) : speed_(speed), begin_(std::chrono::steady_clock::now()) {}

  bool unlimited() const { return speed_ <= 0.0; }
  /// Real seconds since the beginning.
  double real() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }

  /// Real seconds to wait for the host; 0 when the controller has something to do meanwhile.
  template <class Controller>
  double wait(const Controller& controller) {
    const auto event = controller.next_event();
    if (!event) return kTick;
    return unlimited() ? patience(controller) : std::clamp(*event / speed_ - real(), 0.0, kTick);
  }

  /// Before the host's bytes are looked at: paced time goes on by itself.
  template <class Controller>
  void follow(Controller& controller) const {
    if (!unlimited()) controller.advance(std::max(controller.now(), real() * speed_));
  }

  /// The host has nothing in flight: unlimited time jumps from event to event, a few at a time, so that what
  /// they answer reaches the host soon, and only as far as there is enough to look ahead at.
  template <class Controller>
  void jump(Controller& controller) {
    if (!unlimited()) return;
    for (int i = 0; i < kBurst; ++i) {
      if (patience(controller) > 0.0) return;
      const auto event = controller.next_event();
      if (!event) return;
      controller.advance(*event);
    }
  }

  /// The host asks whether there is room: unlimited time has gone on until there is. It then keeps the queue
  /// full, and simulated time does not depend on how fast it is.
  template <class Controller>
  void make_room(Controller& controller) const {
    while (unlimited() && !controller.has_room()) {
      const auto event = controller.next_event();
      if (!event) return;
      controller.advance(*event);
    }
  }

  /// Once in kFlushEvery; for options.flush.
  bool time_to_flush() {
    const double now = real();
    if (now - flushed_ < kFlushEvery) return false;
    flushed_ = now;
    return true;
  }

 private:
  /// Real seconds for which a host that could send more blocks is still waited for. A computer that is busy
  /// must not look like a machine that starves.
  template <class Controller>
  double patience(const Controller& controller) {
    const Motion& motion = controller.motion();
    const std::uint64_t known = motion.totals().blocks + motion.slots() - motion.free_slots();
    if (!controller.hungry()) return 0.0;
    if (known != known_) known_ = known, fed_ = real();
    return std::max(0.0, fed_ + kPatience - real());
  }

  static constexpr double kPatience = 0.02;  // some turns of the host's scheduler, s
  static constexpr double kTick = 0.05;      // the watchdog and --once need no finer one, s
  static constexpr double kFlushEvery = 0.1;
  static constexpr int kBurst = 16;  // half a usual planner: the host refills while the rest is executed
  double speed_;
  std::chrono::steady_clock::time_point begin_;
  double flushed_ = 0.0;
  std::uint64_t known_ = 0;  ///< blocks that the machine was ever given
  double fed_ = 0.0;         ///< when it was given the last one
};

}  // namespace tiltfeed::sim
