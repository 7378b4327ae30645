#include "desk/webhooks/run_cursor.h"

#include <utility>

namespace tiltfeed::desk {

RunCursor::RunCursor(std::optional<RunMark> known)
    : mode_(known ? Mode::kFollow : Mode::kFirst), mark_(known.value_or(RunMark{})), read_(mark_) {}

std::uint64_t RunCursor::ask_from() const {
  if (mode_ != Mode::kFollow) return next_;
  return mark_.run > 0 ? mark_.run - 1 : 0;  // with the marked run
}

bool RunCursor::finds_mark(const HistoryPage& page) const {
  return mark_.run == 0 ||
         (!page.runs.empty() && page.runs[0].run == mark_.run && page.runs[0].began == mark_.began);
}

std::optional<RunCursor::News> RunCursor::take(const HistoryPage& page) {
  if (mode_ == Mode::kFollow && !finds_mark(page)) {
    mode_ = Mode::kAnew;
    next_ = 0;
    read_ = {0, mark_.began};
    return std::nullopt;
  }
  bool stands = false;  // at a run that goes on
  for (const ToldRun& run : page.runs) {
    if (mode_ == Mode::kFollow && run.run <= mark_.run) continue;
    if (run.goes_on()) on_machine_ = run, stands = true;
    if (stands) break;
    read_ = {run.run, run.began};
    next_ = run.run;
    const bool news = mode_ == Mode::kFollow || (mode_ == Mode::kAnew && run.began > mark_.began);
    if (news) ended_.push_back(run);
    if (ended_.size() > kMostNews) ended_.erase(ended_.begin()), ++cut_;
  }
  const bool more = page.more && !stands;
  if (more && mode_ != Mode::kFollow) return std::nullopt;
  if (!stands && !more) on_machine_.reset();
  const bool anew = std::exchange(mode_, Mode::kFollow) == Mode::kAnew;
  mark_ = read_;
  return News{std::exchange(ended_, {}), mark_, more, anew, std::exchange(cut_, 0)};
}

}  // namespace tiltfeed::desk
