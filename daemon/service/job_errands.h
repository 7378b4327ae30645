#pragma once
// What takes long, beside the loop that answers: each in a thread or a process of its own, its end taken by
// the loop.

#include <cstdint>
#include <functional>
#include <future>
#include <list>
#include <string>

#include "daemon/service/copy_process.h"
#include "daemon/service/spool.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// What is answered in the end: one JSON line, or why not.
using Done = std::function<void(Result<std::string>)>;

/// Work whose outcome the loop takes. Properties: work runs on a thread of its own and touches nothing of the
/// loop's; what it returns, and `done`, run on the loop.
class Errands {
 public:
  using Then = std::function<Result<std::string>()>;
  struct What {
    std::uint64_t job = 0;
    bool starts = false;   ///< the job gets onto the machine when it ends well
    bool machine = false;  ///< nobody else may have the machine meanwhile
  };
  void begin(const What& what, std::function<Then()> work, Done done);
  /// Takes what has ended.
  void tick();
  bool empty() const { return errands_.empty(); }
  /// The job that has the machine or will have it; 0: none.
  std::uint64_t machine() const;
  /// The start of this job will come to nothing; of any, where 0 is given. False: there is none.
  bool withdraw(std::uint64_t job);

 private:
  struct Errand {
    What what;
    std::future<Then> work;
    Done done;
    bool withdrawn = false;
  };
  std::list<Errand> errands_;
};

/// Which copies a submission asks for. Errors: kUsage (the number of files).
Result<std::vector<CopyItem>> copy_items(bool program, const std::vector<int>& files);

/// Submissions on their way into the spool.
class Arrivals {
 public:
  static constexpr std::size_t kAtOnce = 4;
  void add(SpooledJob job, HandedFiles files, Done done);
  /// Begins, ends and answers what is due.
  void tick(Spool& spool);
  bool empty() const { return arrivals_.empty(); }
  bool is_arriving(std::uint64_t job) const;
  /// Its copy ends; who submitted it is told.
  void drop(std::uint64_t job);

 private:
  struct Arrival {
    SpooledJob job;
    HandedFiles files;
    Done done;
    std::optional<CopyProcess> copy;
  };
  bool begin(Spool& spool, Arrival& arrival);
  std::list<Arrival> arrivals_;
};

}  // namespace tiltfeed::daemon
