// A program sent over one link, and what it took:
//
//   link_bench PROGRAM LINK [HOLDS]
//
// prints blocks, seconds, those of them from the first block to the last that left, processor seconds, the
// process's peak memory in MB and, for HOLDS feed holds asked for on the way, the longest time in ms until
// the machine said that it holds ("-": none). A hold is ended after it was seen.

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

#include "daemon/stream/stream.h"
#include "daemon/wire/modbus_map.h"

namespace {

using namespace tiltfeed;
using namespace tiltfeed::config;
using namespace tiltfeed::daemon;
using Steady = std::chrono::steady_clock;

double seconds_since(Steady::time_point begin) {
  return std::chrono::duration<double>(Steady::now() - begin).count();
}

double processor_seconds() {
  rusage used{};
  ::getrusage(RUSAGE_SELF, &used);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

double peak_megabytes() {
  std::ifstream in("/proc/self/status");
  for (std::string line; std::getline(in, line);)
    if (line.starts_with("VmHWM:")) return std::atof(line.c_str() + 6) * 1024.0 / 1e6;
  return 0.0;
}

/// Asks for feed holds at even distances and watches the wire for the machine's word of them.
class Holds {
 public:
  Holds(int count, bool messages) : count_(count), messages_(messages) {}

  bool progress(const SendState& state) {
    if (state.phase == Phase::kRun && began_ == Steady::time_point{}) began_ = Steady::now();
    if (state.phase == Phase::kDrain || (state.phase == Phase::kDone && streaming == 0.0))
      streaming = seconds_since(began_);
    if (count_ == 0) return true;
    const std::uint64_t part = state.total / static_cast<std::uint64_t>(count_ + 1);
    if (asked_ < count_ && !waiting_ && state.phase == Phase::kRun &&
        state.acknowledged > part * static_cast<std::uint64_t>(asked_ + 1)) {
      ++asked_;
      waiting_ = true;
      asked_at_ = Steady::now();
      commands.push({Order::kHold});
    }
    if (!waiting_ && state.phase == Phase::kHold) commands.push({Order::kResume});
    return true;
  }
  void traffic(Way way, std::string_view bytes) {
    if (way != Way::kIn || !waiting_ || !says_hold(bytes)) return;
    waiting_ = false;
    longest_ms = std::max(longest_ms, 1e3 * seconds_since(asked_at_));
  }

  CommandQueue commands;
  double longest_ms = 0.0, streaming = 0.0;

 private:
  bool says_hold(std::string_view bytes) const {
    if (!messages_) return bytes.find("<Hold") != bytes.npos;
    const ModbusReply reply = unpack_reply(bytes);
    return reply.words.size() == kStatusWords &&
           parse_ring_status(reply.words, false).state == RingState::kHold;
  }

  int count_, asked_ = 0;
  bool messages_, waiting_ = false;
  Steady::time_point asked_at_, began_{};
};

}  // namespace

int main(int count, char** arguments) {
  if (count < 3 || count > 4) {
    std::fprintf(stderr, "usage: link_bench PROGRAM LINK [HOLDS]\n");
    return 2;
  }
  const auto link = parse_link(arguments[2]);
  if (!link) {
    std::fprintf(stderr, "%s\n", link.error().message.c_str());
    return 2;
  }
  const bool messages = link->kind == LinkKind::kModbusTcp || link->kind == LinkKind::kModbusRtu;
  const int wanted = count == 4 ? std::atoi(arguments[3]) : 0;
  Holds holds(wanted, messages);
  StreamHooks hooks;
  hooks.progress = [&](const SendState& state) { return holds.progress(state); };
  if (wanted > 0) {
    hooks.commands = &holds.commands;
    hooks.traffic = [&](Way way, std::string_view bytes, Time) { holds.traffic(way, bytes); };
  }
  const auto report = send_program(arguments[1], *link, {}, hooks);
  if (!report) {
    std::fprintf(stderr, "%s\n", report.error().message.c_str());
    return 1;
  }
  std::printf("%llu %.3f %.3f %.3f %.1f ", static_cast<unsigned long long>(report->lines), report->seconds,
              holds.streaming, processor_seconds(), peak_megabytes());
  if (wanted > 0)
    std::printf("%.1f\n", holds.longest_ms);
  else
    std::printf("-\n");
}
