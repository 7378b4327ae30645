#pragma once
// The simulated Modbus ring on a port of its own, four times as fast as time, served by a thread until the
// end of the test.

#include <gtest/gtest.h>
#include <unistd.h>

#include <future>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "sim/wire/endpoint.h"
#include "tests/shapes/wide_machine.h"

namespace tiltfeed {
using namespace config;

/// The simulated ring on a port of its own; `feeds` are the Y of what it executed.
class TcpRing {
 public:
  TcpRing() {
    EXPECT_EQ(::pipe(stop_), 0);
    std::promise<std::string> where;
    std::future<std::string> known = where.get_future();
    thread_ = std::thread([this, promise = std::move(where)]() mutable {
      sim::ModbusController ring(wide_machine(), {}, {}, [this](const sim::TraceRow& row) {
        const std::lock_guard lock(mutex_);
        if (row.command.op == sim::Op::kFeed) feeds_.push_back(static_cast<int>(row.command.target.y));
      });
      sim::EndpointOptions options;
      options.stop_fd = stop_[0];
      options.speed = 4.0;
      options.ready = [&](const std::string& text) { promise.set_value(text); };
      EXPECT_TRUE(sim::serve_modbus_tcp(ring, "127.0.0.1", 0, options));
    });
    place = known.get();
  }
  TcpRing(const TcpRing&) = delete;
  TcpRing& operator=(const TcpRing&) = delete;
  ~TcpRing() {
    stop();
    ::close(stop_[0]);
    ::close(stop_[1]);
  }
  void stop() {
    if (!thread_.joinable()) return;
    EXPECT_EQ(::write(stop_[1], "x", 1), 1);
    thread_.join();
  }
  std::vector<int> feeds() const {
    const std::lock_guard lock(mutex_);
    return feeds_;
  }
  std::string place;

 private:
  int stop_[2] = {-1, -1};
  std::thread thread_;
  mutable std::mutex mutex_;
  std::vector<int> feeds_;
};

}  // namespace tiltfeed
