// Programs that are moved into the watch folder are submitted, one after the other.

#include <unistd.h>

#include <filesystem>

#include "daemon/service/job_service.h"

namespace tiltfeed::daemon {

namespace {

constexpr std::chrono::seconds kWatchAgain{1};

}  // namespace

/// Beside the loop: the folder may be on a disk of another computer, which has gone.
void JobService::look_into_watch_folder() {
  const auto now = std::chrono::steady_clock::now();
  if (watching_ || leaving_ || now < watch_due_) return;
  watching_ = true;
  watch_due_ = now + kWatchAgain;
  const auto look = [this, folder = config_.watch, seen = seen_]() -> Errands::Then {
    return [this, found = look_into(folder, seen)]() -> Result<std::string> {
      take_watched(found);
      return std::string();
    };
  };
  errands_.begin({}, look, [](const Result<std::string>&) {});
}

void JobService::take_watched(const WatchedFolder& found) {
  seen_ = found.seen;
  if (found.trouble != watch_trouble_ && !found.trouble.empty()) log(Severity::kError, 0, found.trouble);
  watch_trouble_ = found.trouble;
  watching_ = !found.path.empty();
  if (!watching_) return;
  SpooledJob job;
  job.name = std::filesystem::path(found.path).stem().string();
  job.program = true;
  job.user = ::getuid();
  seen_[found.path] = found.stamp;
  arrivals_.add(job, std::move(*found.files),
                [this, path = found.path, stamp = found.stamp](const Result<std::string>& taken) {
                  if (taken) return forget_watched(path, stamp);
                  watching_ = false;
                  log(Severity::kWarning, 0,
                      path + ": " + taken.error().message + "; it stays there until it changes");
                });
}

/// Only now: until the spool has it, the file may be all there is of the program.
void JobService::forget_watched(const std::string& path, const FileStamp& stamp) {
  const auto remove = [this, path, stamp]() -> Errands::Then {
    return [this, path, gone = remove_taken(path, stamp)]() -> Result<std::string> {
      watching_ = false;
      watch_due_ = {};  // the next at once
      log(gone ? Severity::kInfo : Severity::kError, 0,
          path + ": taken from the watch folder" +
              (gone ? "" : "; it cannot be removed, and is taken again where it changes"));
      return std::string();
    };
  };
  errands_.begin({}, remove, [](const Result<std::string>&) {});
}

}  // namespace tiltfeed::daemon
