#pragma once
// A job into a spool, from the files to the row, as the service does it beside its loop.

#include <unistd.h>

#include <thread>

#include "daemon/service/job_service.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;

inline Result<std::uint64_t> add_job(Spool& spool, const SpooledJob& job, const std::vector<int>& files) {
  const auto items = copy_items(job.program, files);
  if (!items) return tl::unexpected<Error>(items.error());
  SpooledJob added = job;
  const Result<std::uint64_t> id = spool.begin(job);
  if (!id) return id;
  added.id = *id;
  Result<CopyProcess> copy = CopyProcess::start(spool.folder_of(*id), *items);
  std::optional<Result<void>> done;
  if (!copy) done = tl::unexpected<Error>(copy.error());
  while (!done) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    done = copy->check();
  }
  if (*done) done = spool.finish(added);
  if (*done) return id;
  static_cast<void>(spool.remove(*id));
  return tl::unexpected<Error>(done->error());
}

/// What the job service answers; meanwhile only what was asked for is done.
inline std::string answer_of(JobService& jobs, const ApiRequest& request, std::uint32_t user = 1000,
                             const std::vector<int>& files = {}) {
  std::vector<int> own;
  for (const int file : files) own.push_back(::dup(file));
  std::optional<std::string> said;
  jobs.ask(request, user, HandedFiles(own), [&](std::string line) { said = std::move(line); });
  while (!said) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    jobs.take_ends();
  }
  return *said;
}

}  // namespace tiltfeed
