#include "daemon/service/job_errands.h"

#include <nlohmann/json.hpp>

#include "daemon/service/api.h"

namespace tiltfeed::daemon {

void Errands::begin(const What& what, std::function<Then()> work, Done done) {
  errands_.push_back({what, std::async(std::launch::async, std::move(work)), std::move(done), false});
}

void Errands::tick() {
  for (auto at = errands_.begin(); at != errands_.end();) {
    if (at->work.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
      ++at;
      continue;
    }
    Errand ended = std::move(*at);  // what follows it may have the machine
    at = errands_.erase(at);
    const Then then = ended.work.get();
    ended.done(ended.withdrawn ? fail(Code::kCancelled, "job " + std::to_string(ended.what.job) +
                                                            " was stopped before it began; nothing moved")
                               : then());
    at = errands_.begin();  // the end of one may have begun or dropped others
  }
}

std::uint64_t Errands::machine() const {
  for (const Errand& errand : errands_)
    if (errand.what.machine) return errand.what.job;
  return 0;
}

bool Errands::withdraw(std::uint64_t job) {
  bool any = false;
  for (Errand& errand : errands_)
    if (errand.what.starts && !errand.withdrawn && (job == 0 || errand.what.job == job))
      any = errand.withdrawn = true;
  return any;
}

Result<std::vector<CopyItem>> copy_items(bool program, const std::vector<int>& files) {
  if (files.size() != (program ? 1u : 2u))
    return fail(Code::kUsage,
                program ? "a program comes as one file" : "a job comes as two files: its text and its STL");
  if (program) return std::vector<CopyItem>{{files[0], "program.nc", kMaxProgramBytes}};
  return std::vector<CopyItem>{{files[0], "job.yaml", kMaxJobBytes}, {files[1], "part.stl", kMaxPartBytes}};
}

void Arrivals::add(SpooledJob job, HandedFiles files, Done done) {
  arrivals_.push_back({std::move(job), std::move(files), std::move(done), std::nullopt});
}

/// False when it has ended already, and is answered.
bool Arrivals::begin(Spool& spool, Arrival& arrival) {
  const auto items = copy_items(arrival.job.program, arrival.files.all());
  if (!items) return arrival.done(tl::unexpected<Error>(items.error())), false;
  const Result<std::uint64_t> id = spool.begin(arrival.job);
  if (!id) return arrival.done(tl::unexpected<Error>(id.error())), false;
  arrival.job.id = *id;
  Result<CopyProcess> copy = CopyProcess::start(spool.folder_of(*id), *items);
  if (copy) return arrival.copy.emplace(std::move(*copy)), true;
  static_cast<void>(spool.remove(*id));
  return arrival.done(tl::unexpected<Error>(copy.error())), false;
}

void Arrivals::tick(Spool& spool) {
  std::size_t places = kAtOnce;
  for (auto at = arrivals_.begin(); at != arrivals_.end() && places > 0;) {
    if (!at->copy && !begin(spool, *at)) {
      at = arrivals_.erase(at);
      continue;
    }
    std::optional<Result<void>> ended = at->copy->check();
    if (!ended) {
      --places;
      ++at;
      continue;
    }
    const Arrival arrived = std::move(*at);
    at = arrivals_.erase(at);
    if (*ended) ended = spool.finish(arrived.job);
    if (*ended) {
      const nlohmann::ordered_json json = {{"v", kApiVersion}, {"ok", true}, {"job", arrived.job.id}};
      arrived.done(json.dump() + "\n");
    } else {
      static_cast<void>(spool.remove(arrived.job.id));
      arrived.done(tl::unexpected<Error>(ended->error()));
    }
  }
}

bool Arrivals::is_arriving(std::uint64_t job) const {
  for (const Arrival& arrival : arrivals_)
    if (arrival.copy && arrival.job.id == job) return true;
  return false;
}

void Arrivals::drop(std::uint64_t job) {
  for (auto at = arrivals_.begin(); at != arrivals_.end(); ++at) {
    if (!at->copy || at->job.id != job) continue;
    const Done done = std::move(at->done);
    arrivals_.erase(at);
    return done(fail(Code::kCancelled, "job " + std::to_string(job) + " was removed while it came in"));
  }
}

}  // namespace tiltfeed::daemon
