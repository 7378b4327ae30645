#pragma once
// Up to which run of the history everything has been told, and what is new in it.

#include <cstdint>
#include <optional>
#include <vector>

#include "desk/webhooks/hook_message.h"

namespace tiltfeed::desk {

/// A run that was told, or passed over. `run` 0: the one before the first.
struct RunMark {
  std::uint64_t run = 0;
  std::int64_t began = 0;  ///< seconds since 1970
  bool operator==(const RunMark&) const = default;
};

/// Properties: each run that ends is news once, in the order of the runs, whenever the pages come. At the
/// first contact what has ended is passed over. The marked run is asked for each time: where it is not the
/// same any more, the spool is another one (restored from a copy, made anew, or its past forgotten), and
/// news are the runs that began after the marked one did.
class RunCursor {
 public:
  /// News of more runs at once are cut down to the newest.
  static constexpr std::size_t kMostNews = 1000;

  /// `known`: nothing at the first contact.
  explicit RunCursor(std::optional<RunMark> known);

  /// `from` of the request for the next page.
  std::uint64_t ask_from() const;
  struct News {
    std::vector<ToldRun> ended;
    RunMark mark;           ///< everything up to it is told with these
    bool more = false;      ///< the next page is there to be asked for
    bool anew = false;      ///< the spool is another one
    std::uint64_t cut = 0;  ///< news that were too many
  };
  /// The page that was asked for, of two runs or more where there are more. Nothing: ask for the next one
  /// first.
  std::optional<News> take(const HistoryPage& page);
  /// The run that goes on, as it was told last.
  const std::optional<ToldRun>& on_machine() const { return on_machine_; }

 private:
  enum class Mode : std::uint8_t { kFirst, kFollow, kAnew };
  bool finds_mark(const HistoryPage& page) const;

  Mode mode_;
  RunMark mark_;            // told
  RunMark read_;            // of the pages that were read since
  std::uint64_t next_ = 0;  // but for kFollow: the next page is after this run
  std::vector<ToldRun> ended_;
  std::uint64_t cut_ = 0;
  std::optional<ToldRun> on_machine_;
};

}  // namespace tiltfeed::desk
