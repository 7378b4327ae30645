#pragma once
// What a reader of CL text left out or took in another sense: each once, with its first line and its count.

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

namespace tiltfeed {

class AptNotes {
 public:
  void add(std::uint32_t line, const std::string& text) {
    const auto known =
        std::find_if(notes_.begin(), notes_.end(), [&](const Note& one) { return one.text == text; });
    if (known == notes_.end())
      notes_.push_back({text, line, 1});
    else
      ++known->count;
  }
  /// "NAME:LINE: TEXT (3 times)", in the order of their first lines.
  void append_to(std::vector<std::string>& texts, const std::string& name) const {
    for (const Note& one : notes_)
      texts.push_back(name + ":" + std::to_string(one.line) + ": " + one.text +
                      (one.count > 1 ? " (" + std::to_string(one.count) + " times)" : ""));
  }

 private:
  struct Note {
    std::string text;
    std::uint32_t line = 0;
    int count = 0;
  };
  std::vector<Note> notes_;
};

}  // namespace tiltfeed
