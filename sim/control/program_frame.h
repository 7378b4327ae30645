#pragma once
// What stands round the moves of a program that Tiltfeed posted: safe words, work offset, retracts, the
// register of the tool's length, the end. Damage to these changes no move of the text, and yet the machine's.

#include <istream>
#include <memory>
#include <string>
#include <string_view>

#include "config/job.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::sim {

class Frame;
class Lines;

/// A program without the header of a posted one passes. Errors: kInput as name:line: a safe word is missing
/// before the first move, the work offset or the length register is not the job's, the tool is not retracted
/// before the first move, at a tool change or at the end, or the program has no end. Reads the stream from
/// where it is.
Result<void> check_frame(std::istream& in, const std::string& name, const config::Job& job);

/// The same, line by line, beside who reads the program anyway.
class FrameCheck {
 public:
  /// Outlived by `job`. `name`: of the program, for messages.
  FrameCheck(std::string name, const config::Job& job);
  FrameCheck(FrameCheck&&) noexcept;
  ~FrameCheck();
  /// The next line.
  Result<void> take(std::string_view line);
  /// Lines from here on say nothing.
  bool done() const;
  /// All that is left of the program.
  Result<void> take_rest(Lines& lines);

 private:
  tl::unexpected<Error> wrong(const std::string& what) const;
  std::string name_;
  std::unique_ptr<Frame> frame_;
};

}  // namespace tiltfeed::sim
