#pragma once
// What the tool reaches of the part on the desk, and shapes through its facets: a process of its own keeps
// the part loaded and answers (desk/reach).

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "desk/api/part_work.h"
#include "desk/http/http_message.h"
#include "desk/work/child_process.h"

namespace tiltfeed::desk {

/// The part as it is asked about.
struct AskedPart {
  std::string stl;
  std::uint64_t id = 0;
  double unit_mm = 1.0;
  std::vector<std::string> bodies = {};  ///< that are drawn; empty: all
  double deviation = 0.0;                ///< of facets from surfaces, mm; 0: nobody has said
};

/// What of which job.
struct AskedJob {
  std::uint64_t id = 0;  ///< of the text that it was made of; the answer has it, too
  std::string text;
  std::string operation = {};  ///< its name; empty: the first
};

class ReachWork {
 public:
  /// `program`: what answers (this program); `folder`: where its files are kept.
  ReachWork(std::string program, std::string folder, Teller tell)
      : program_(std::move(program)), folder_(std::move(folder)), tell_(std::move(tell)) {}

  /// The number of the question; its answer is the event `reach`. Of several that wait the newest is
  /// answered. Errors: kIo.
  Result<std::uint64_t> ask(const AskedPart& part, const AskedJob& job, const std::string& machine,
                            bool exact);
  /// The same for the shapes about facets of the file: the event `fit`. Errors: kIo.
  Result<std::uint64_t> fit(const AskedPart& part, const std::vector<std::uint32_t>& facets,
                            double spread_deg);

  /// JSON: null, or the newest answer for reach.
  std::string describe() const { return told_.empty() ? "null" : told_; }
  /// A byte a facet, of the newest answer.
  Reply map() const;

  int descriptor() const { return child_ ? child_->descriptor() : -1; }
  void hear();

 private:
  Result<std::uint64_t> say(const std::string& question);
  void take(const std::string& line);

  std::string program_, folder_;
  Teller tell_;
  std::uint64_t asked_ = 0, part_ = 0;
  std::string told_, map_;
  std::optional<ChildProcess> child_;
};

}  // namespace tiltfeed::desk
