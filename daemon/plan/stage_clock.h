#pragma once
// What a planning says while it runs, and how long its stages take.

#include <algorithm>
#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "pathgen/options/plan_report.h"

namespace tiltfeed::daemon {

/// Both on the thread that plans; either may be empty.
struct PlanListener {
  std::function<bool(const char* stage, double share)> stage;  ///< 0..1; false: stop
  std::function<void(const std::string& text)> note;           ///< a line for the user, before the end

  bool show(const char* name, double share) const { return !stage || stage(name, share); }
  void say(const std::string& text) const {
    if (note) note(text);
  }
};

/// Wall time by stage, in the order in which they began.
class StageClock {
 public:
  template <class Function>
  auto time(const char* stage, Function function) {
    const auto start = std::chrono::steady_clock::now();
    auto result = function();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    add({stage, seconds});
    return result;
  }
  void add(const pathgen::StageTime& time) {
    const auto before = std::find_if(times.begin(), times.end(),
                                     [&](const pathgen::StageTime& one) { return one.stage == time.stage; });
    if (before != times.end())
      before->seconds += time.seconds;
    else
      times.push_back(time);
  }
  std::vector<pathgen::StageTime> times;
};

}  // namespace tiltfeed::daemon
