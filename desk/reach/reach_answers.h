#pragma once
// What the tool reaches of the part with a job, asked again and again of a process that keeps the part
// loaded; and shapes fitted through facets that a person has picked.

#include <functional>
#include <memory>
#include <string>

namespace tiltfeed::desk {

class ReachAnswers {
 public:
  ReachAnswers();
  ~ReachAnswers();

  /// Answers one line of JSON by one line of JSON; both in desk/reach/README.md. A question's job file is
  /// removed. `newer`: whether another question waits; an exact answer is then given up.
  std::string answer(const std::string& question, const std::function<bool()>& newer);

 private:
  struct Kept;
  std::unique_ptr<Kept> kept_;
};

/// Questions from the standard input, answers to the standard output, until the input ends. Of questions for
/// reach that wait together only the last is answered. The exit status.
int answer_reach();

}  // namespace tiltfeed::desk
