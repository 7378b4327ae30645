#pragma once
// The adapter: agents connect over TCP and are told what changes.

#include <chrono>
#include <functional>
#include <list>
#include <memory>
#include <string>
#include <vector>

#include "daemon/mtconnect/observations.h"

struct pollfd;

namespace tiltfeed::daemon {

/// Properties: each agent is told all values when it comes, then what changes, in the order in which it
/// changed. `* PING` is answered at once. An agent that has pinged and is then silent for two periods, or
/// that leaves kMostUnread bytes unread, is let go; the others notice nothing. At most kAgents at a time.
class Adapter {
 public:
  static constexpr std::size_t kAgents = 16, kMostUnread = std::size_t{1} << 20;
  static constexpr std::chrono::milliseconds kPeriod{10'000};
  using Time = std::chrono::steady_clock::time_point;

  /// Listens at HOST:PORT; port 0: a free one. Errors: kUsage: no address; kIo: it cannot be had.
  static Result<Adapter> open(const std::string& address, std::vector<DataItem> items, std::string version);
  Adapter(Adapter&& other) noexcept;
  Adapter& operator=(Adapter&&) = delete;
  ~Adapter();

  /// Where it listens, with the port that was taken.
  const std::string& address() const { return address_; }
  /// To every agent that is there, and to those that come later.
  void tell(const Observations& now);
  /// Waits for agents for at most so long, and serves them.
  void serve(std::chrono::milliseconds patience);
  std::size_t agents() const { return agents_.size(); }

 private:
  struct Agent {
    int fd = -1;
    std::string in, out;
    Time heard;
    bool pings = false, gone = false;
  };
  Adapter(int fd, std::string address, std::vector<DataItem> items, std::string version)
      : fd_(fd), address_(std::move(address)), items_(std::move(items)), version_(std::move(version)) {}
  void accept_agents();
  void talk(Agent& agent, short events);
  static void send_out(Agent& agent);

  int fd_ = -1;
  std::string address_;
  std::vector<DataItem> items_;
  std::string version_;
  Observations now_;  // empty: nothing was told yet
  std::list<Agent> agents_;
};

}  // namespace tiltfeed::daemon
