#pragma once
// The simulated Grbl machine behind a TCP port of its own, served by a thread until the end of the test.

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <future>
#include <thread>

#include "sim/wire/endpoint.h"

namespace tiltfeed {
using namespace config;

class TcpMachine {
 public:
  TcpMachine(const MachineModel& model, const sim::GrblOptions& options, const std::string& faults = "",
             double speed = 0.0, bool web_socket = false) {
    EXPECT_EQ(::pipe(stop_), 0);
    std::promise<std::string> where;
    std::future<std::string> known = where.get_future();
    const auto script = sim::parse_fault_script(faults, "faults");
    EXPECT_TRUE(script);
    thread_ =
        std::thread([this, model, options, script, speed, web_socket, promise = std::move(where)]() mutable {
          sim::GrblController controller(model, {}, options, [this](const sim::TraceRow& row) {
            x = row.command.target.x;
            ++executed;
          });
          sim::EndpointOptions endpoint;
          endpoint.stop_fd = stop_[0];
          endpoint.speed = speed;
          endpoint.faults = *script;
          bool told = false;
          endpoint.ready = [&](const std::string& text) {
            if (!std::exchange(told, true)) promise.set_value(text);
          };
          EXPECT_TRUE(web_socket ? sim::serve_ws(controller, "127.0.0.1:0", endpoint)
                                 : sim::serve_tcp(controller, "127.0.0.1:0", endpoint));
          spindle = controller.motion().accessories().spindle;
          resets = controller.totals().resets;
          at_x = controller.motion().position().x;
        });
    place = known.get();
  }
  ~TcpMachine() { end(); }
  TcpMachine(const TcpMachine&) = delete;
  TcpMachine& operator=(const TcpMachine&) = delete;

  /// Switches it off: what follows `executed` is known then.
  void end() {
    if (!thread_.joinable()) return;
    EXPECT_EQ(::write(stop_[1], "x", 1), 1);
    thread_.join();
    ::close(stop_[0]);
    ::close(stop_[1]);
  }

  std::string place;
  std::atomic<std::size_t> executed{0};
  std::atomic<double> x{0.0};  ///< of the newest executed block
  double spindle = -1.0, at_x = 0.0;
  std::uint64_t resets = 0;

 private:
  int stop_[2] = {-1, -1};
  std::thread thread_;
};

}  // namespace tiltfeed
