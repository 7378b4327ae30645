#pragma once
// What stands round the moves of a program that Tiltfeed posted: safe words, work offset, retracts, the
// register of the tool's length, the end. Damage to these changes no move of the text, and yet the machine's.

#include <istream>
#include <memory>
#include <span>
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
/// `operations`: those of one job that the program has; of several each begins with its mark, in their order.
Result<void> check_frame(std::istream& in, const std::string& name, std::span<const config::Job> operations);

/// The same, line by line, beside who reads the program anyway.
class FrameCheck {
 public:
  /// Outlived by `operations`. `name`: of the program, for messages.
  FrameCheck(std::string name, std::span<const config::Job> operations);
  FrameCheck(FrameCheck&&) noexcept;
  ~FrameCheck();
  /// The next line.
  Result<void> take(std::string_view line);
  /// Lines from here on say nothing.
  bool done() const;
  /// The operation that the last line belongs to, counted from 0.
  std::size_t operation() const;
  /// All that is left of the program.
  Result<void> take_rest(Lines& lines);

 private:
  tl::unexpected<Error> wrong(const std::string& what) const;
  std::string name_;
  std::unique_ptr<Frame> frame_;
};

}  // namespace tiltfeed::sim
