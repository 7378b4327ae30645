#pragma once
// The miscellaneous functions in program text: tool, spindle, coolant, cutter compensation, stops and dwells.

#include <optional>
#include <string>

#include "daemon/post/dialect_words.h"
#include "daemon/post/nc_program.h"
#include "daemon/post/text_language.h"
#include "kinematics/basics/path_event.h"

namespace tiltfeed::daemon {

/// Takes them line by line into the program's operations. It refers to program and language.
class FunctionReader {
 public:
  FunctionReader(NcProgram& program, const TextLanguage& language) : program_(program), language_(language) {
    program_.operations.emplace_back();
  }

  TextOperation& operation() { return program_.operations.back(); }
  /// A Heidenhain's TOOL CALL with its number and speed. A text: why it cannot be read.
  std::optional<std::string> tool_call(const std::string& text);
  /// T, S and M, but M codes that say how motion is read.
  void machine_codes(const DialectWords& words);
  /// G40 to G42, R0, RL and RR of a Heidenhain dialogue, and the registers of length and radius.
  void compensation(const DialectWords& words, int plane);
  /// G4. A text: why it cannot be read.
  std::optional<std::string> dwell(const DialectWords& words);
  /// A change of the spindle or coolant, or a stop; what is in force already is no change.
  void event(EventKind kind, double value);

 private:
  void next_tool(int number);

  NcProgram& program_;
  const TextLanguage& language_;
  bool changing_ = false;         ///< the next M0 is a tool change
  bool changes_by_code_ = false;  ///< M6 has come
  bool compensated_ = false;
  int selected_ = -1;  ///< the last T; -1: none
  int turn_ = 0;       ///< spindle: 3, 4, or 0
  int told_plane_ = 17;
  double speed_ = 0.0, spindle_ = 0.0, coolant_ = 0.0;
};

}  // namespace tiltfeed::daemon
