#pragma once
// How far a stage is, from the middle of its loops, and the user's word to stop them.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <thread>
#include <utility>

namespace tiltfeed::pathgen {

/// Takes the share of the work that is done, 0..1; returns false when the user wants no more of it. Empty:
/// nobody listens.
using ReportShare = std::function<bool(double)>;

/// For work that is only the part `from`..`to` of what `report` counts. `report` must outlive it.
inline ReportShare part_of(const ReportShare& report, double from, double to) {
  if (!report) return {};
  return [&report, from, to](double share) { return report(from + (to - from) * share); };
}

/// Counts units of work that any thread does. Reports on the thread that made it only: every hundredth of the
/// units that it sees pass there, and whenever kLookEvery has gone by. Every thread takes part in a loop that
/// it starts, so that thread sees the count grow.
class Watch {
 public:
  Watch(const ReportShare& report, std::size_t units)
      : report_(report), units_(std::max<std::size_t>(units, 1)) {}

  /// Before each unit, or before so many: false where the user has stopped the work.
  bool next(std::size_t count = 1) {
    const std::size_t done = done_.fetch_add(count, std::memory_order_relaxed);
    if (report_ && std::this_thread::get_id() == owner_ && !stopped()) look(done);
    return !stopped();
  }
  bool stopped() const { return stopped_.load(std::memory_order_relaxed); }

 private:
  static constexpr std::size_t kLooks = 100;
  static constexpr std::chrono::milliseconds kLookEvery{20};

  void look(std::size_t done) {
    const auto now = std::chrono::steady_clock::now();
    if (done < due_ && now < again_) return;
    due_ = done + std::max<std::size_t>(units_ / kLooks, 1);
    again_ = now + kLookEvery;
    const double share = static_cast<double>(std::min(done, units_)) / static_cast<double>(units_);
    if (!report_(share)) stopped_.store(true, std::memory_order_relaxed);
  }

  const ReportShare& report_;
  const std::size_t units_;
  const std::thread::id owner_ = std::this_thread::get_id();
  std::atomic<std::size_t> done_{0};
  std::atomic<bool> stopped_{false};
  std::size_t due_ = 0;  ///< of the owner, as the next
  std::chrono::steady_clock::time_point again_{};
};

}  // namespace tiltfeed::pathgen
