// Programs that are moved into the watch folder are submitted.

#include <fcntl.h>
#include <unistd.h>

#include <filesystem>

#include "daemon/service/job_service.h"

namespace tiltfeed::daemon {

void JobService::look_into_watch_folder() {
  std::error_code failed;
  for (const auto& entry : std::filesystem::directory_iterator(config_.watch, failed)) {
    const std::string path = entry.path().string();
    // Only what was moved in whole: a file that is being written has another name until it is done.
    if (entry.path().extension() != ".nc" || !entry.is_regular_file(failed) || entry.is_symlink(failed))
      continue;
    const int fd = ::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (fd < 0) continue;
    SpooledJob job;
    job.name = entry.path().stem().string();
    job.program = true;
    job.user = ::getuid();
    arrivals_.add(job, HandedFiles({fd}), [this, name = job.name](const Result<std::string>& taken) {
      log(taken ? Severity::kInfo : Severity::kWarning, 0,
          config_.watch + "/" + name +
              ".nc: " + (taken ? "taken from the watch folder" : taken.error().message));
    });
    std::filesystem::remove(path, failed);
    if (failed) {  // it would be taken again for ever
      log(Severity::kError, 0, config_.watch + ": what was taken cannot be removed; not watched any more");
      config_.watch.clear();
      return;
    }
  }
}

}  // namespace tiltfeed::daemon
