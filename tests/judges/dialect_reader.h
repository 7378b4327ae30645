#pragma once
// A second reader of every dialect, for the tests: blind to meaning, it looks for letters and numbers, and
// for the few words that tell a motion from the rest. Shares nothing with the writer or the reader of the
// program.

#include <cctype>
#include <cstdlib>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "kinematics/machine/machine.h"

namespace tiltfeed {

struct SeenBlock {
  Joints words;
  bool rapid = true;
  double feed = 0.0;  ///< F in force
  bool states_f = false, whole = false;
};

struct SeenProgram {
  std::vector<SeenBlock> blocks;  ///< where all five words are known
  std::vector<std::string> lines;
  std::string trouble;
};

/// The text without comments, numbers and block ends: "X+1." is {X, "+1."}.
inline std::vector<std::pair<char, std::string>> seen_words(std::string line, bool heidenhain) {
  if (heidenhain) line = line.substr(std::min(line.find_first_not_of("0123456789"), line.size()));
  line = line.substr(0, line.find(';'));
  for (std::size_t at; (at = line.find("=DC(")) != line.npos;) {
    line.erase(line.find(')', at), 1);
    line.erase(at, 4);
  }
  std::vector<std::pair<char, std::string>> words;
  bool comment = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '(') comment = true;
    if (line[i] == ')') comment = false;
    if (comment || !std::isupper(static_cast<unsigned char>(line[i]))) continue;
    const bool alone = i == 0 || !std::isupper(static_cast<unsigned char>(line[i - 1]));
    const std::size_t end = std::min(line.find_first_not_of("+-.0123456789", i + 1), line.size());
    if (alone && end > i + 1) words.emplace_back(line[i], line.substr(i + 1, end - i - 1));
  }
  return words;
}

inline SeenProgram seen_program(const std::string& text, bool heidenhain, char tilt, char rotary) {
  SeenProgram program;
  std::map<char, double> at;
  std::istringstream in(text);
  bool rapid = true;
  double feed = 0.0;
  for (std::string line; std::getline(in, line);) {
    program.lines.push_back(line);
    const auto trouble = [&](const std::string& what) {
      if (program.trouble.empty()) program.trouble = what + " in: " + line;
    };
    for (const char c : line)
      if ((c < ' ' || c > '~') && c != '\r') trouble("not printable ASCII");
    const auto words = seen_words(line, heidenhain);
    std::map<char, std::string> stated;
    bool machine = line.find("SUPA") != line.npos;
    bool elsewhere = machine || line.find("TOOL CALL") != line.npos || line[0] == 'O' ||
                     line.find("CYCL") != line.npos || line.find("FG") != line.npos || line[0] == '%' ||
                     line.find("PGM") != line.npos;
    for (const auto& [letter, number] : words) {
      if (letter == 'G') {
        const double code = std::atof(number.c_str());
        if (code == 0 || code == 1) rapid = code == 0;
        machine = machine || code == 53 || code == 28;
        elsewhere = elsewhere || machine || code == 4;
      }
      machine = machine || (letter == 'M' && number == "91");
      elsewhere = elsewhere || machine;
      stated[letter] = number;
      const double value = std::atof(number.c_str());
      if (value == 0.0 && number.find('-') != number.npos) trouble("-0");
    }
    // In machine coordinates: where that is in the part's, nobody says.
    for (const auto& [letter, number] : stated)
      if (machine) at.erase(letter);
    if (elsewhere) continue;
    if (heidenhain && line.find("FMAX") != line.npos) rapid = true;
    if (heidenhain && stated.contains('F')) rapid = false;
    if (heidenhain && line.find(" L ") != line.npos && line.find("FMAX") == line.npos) rapid = false;
    bool moves = false;
    std::size_t axes = 0;
    for (const char letter : {'X', 'Y', 'Z', tilt, rotary}) {
      if (!stated.contains(letter)) continue;
      at[letter] = std::atof(stated[letter].c_str());
      moves = true;
      ++axes;
    }
    if (stated.contains('F')) feed = std::atof(stated['F'].c_str());
    if (!moves || at.size() < 5) continue;
    program.blocks.push_back(
        {{at['X'], at['Y'], at['Z'], at[tilt], at[rotary]}, rapid, feed, stated.contains('F'), axes == 5});
  }
  return program;
}

}  // namespace tiltfeed
