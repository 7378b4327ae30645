// The process that answers: desk/reach/reach_answers.h.

#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "desk/reach/reach_answers.h"

namespace tiltfeed::desk {
namespace {

/// Whole lines of the standard input.
class Questions {
 public:
  /// A byte can be read without waiting, or a line is there.
  bool waiting() const {
    pollfd in{STDIN_FILENO, POLLIN, 0};
    return kept_.find('\n') != std::string::npos || ::poll(&in, 1, 0) > 0;
  }
  /// The next line; nothing at the end.
  std::optional<std::string> next() {
    while (true) {
      if (const std::size_t end = kept_.find('\n'); end != std::string::npos) {
        std::string line = kept_.substr(0, end);
        kept_.erase(0, end + 1);
        return line;
      }
      std::array<char, 65536> block{};
      const ssize_t count = ::read(STDIN_FILENO, block.data(), block.size());
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) return std::nullopt;
      kept_.append(block.data(), static_cast<std::size_t>(count));
    }
  }

 private:
  std::string kept_;
};

bool is_reach(const std::string& line) {
  const nlohmann::json asked = nlohmann::json::parse(line, nullptr, false);
  return asked.is_object() && asked.value("do", "") == "reach";
}

/// The job of a question that is not answered goes, too.
void forget(const std::string& line) {
  const nlohmann::json asked = nlohmann::json::parse(line, nullptr, false);
  std::error_code ignored;
  if (asked.is_object()) std::filesystem::remove(asked.value("job", ""), ignored);
}

}  // namespace

int answer_reach() {
  ReachAnswers answers;
  Questions questions;
  std::optional<std::string> line = questions.next();
  while (line) {
    std::optional<std::string> then;
    while (is_reach(*line) && questions.waiting() && (then = questions.next())) {
      if (!is_reach(*then)) break;
      forget(*line);
      line = std::move(then);
      then.reset();
    }
    const std::string answer = answers.answer(*line, [&] { return questions.waiting(); });
    if (!answer.empty()) std::cout << answer << std::endl;
    line = then ? std::move(then) : questions.next();
  }
  return 0;
}

}  // namespace tiltfeed::desk
