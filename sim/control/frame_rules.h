#pragma once
// What FrameCheck knows while it goes through a program, and the rules that it holds.

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/job.h"
#include "sim/control/control_words.h"

namespace tiltfeed::sim {

/// Whether the line has these words, whole.
bool says(std::string_view line, std::string_view words);

/// FrameCheck, line by line.
class Frame {
 public:
  using Wrong = std::optional<std::string>;
  /// Outlived by `operations`: those of one job that the program has, in their order; at least one.
  explicit Frame(std::span<const config::Job> operations);

  Wrong take(std::string_view text);
  Wrong end() const {
    if (!posted_ || (ended_ && (closed_ || closing().empty()))) return std::nullopt;
    if (!ended_) return "the program has no end: it was cut off";
    return "the file ends without " + std::string(closing()) + ", which such a control wants: it was cut off";
  }
  /// Nothing behind here is looked at.
  std::uint64_t line() const { return line_; }
  /// The operation that the program is in, counted from 0.
  std::size_t operation() const { return begun_operations_ > 0 ? begun_operations_ - 1 : 0; }
  bool done() const { return (ended_ && (closed_ || closing().empty() || !posted_)) || (moved_ && !posted_); }

 private:
  bool tnc() const {
    return format_.dialect == config::Dialect::kHeidenhain ||
           format_.dialect == config::Dialect::kHeidenhainIso;
  }
  bool counts_length() const {
    return format_.dialect == config::Dialect::kFanuc || format_.dialect == config::Dialect::kHaas;
  }
  /// The lines without comments; those that are comments alone say nothing.
  std::vector<std::string> bare(const std::vector<std::string>& lines) {
    std::vector<std::string> kept;
    for (const std::string& line : lines)
      if (const std::string_view words = bare_line(line, format_.dialect, room_); !words.empty())
        kept.emplace_back(words);
    return kept;
  }
  Wrong read(std::string_view line);
  Wrong read_waiting(std::size_t but);
  Wrong last(std::string_view line);
  bool set_up() const;
  bool left() const;
  /// What the text stands between, beyond the program's own end; empty: nothing.
  std::string_view closing() const;
  void opening(std::string_view line);
  Wrong not_opened() const;
  Wrong header(std::string_view text);
  Wrong operation_begins(std::string_view text);
  Wrong tcp_begins(const ControlWords& words);
  Wrong offset(std::string_view line, const ControlWords& words);
  Wrong tool(std::string_view line, const ControlWords& words);
  Wrong planes(std::string_view line, const ControlWords& words);
  Wrong swivel_data(std::string_view line) const;
  Wrong plane_offset();
  Wrong smoothing(std::string_view line);
  Wrong arc_plane(const ControlWords& words);
  Wrong retract(std::string_view line, const ControlWords& words);
  Wrong length_register(const ControlWords& words);
  Wrong goes_down(const ControlWords& words) const;
  /// Grbl has no registers, a Heidenhain control takes the length with the tool.
  bool wants_length() const { return tool_ > 0 && !tnc() && format_.dialect != config::Dialect::kGrbl; }
  Wrong at_end() const;
  Wrong first_move() const;

  std::span<const config::Job> operations_;
  const bool marked_;  ///< the program says where each operation begins
  std::size_t begun_operations_ = 0;
  const config::Job* job_;  ///< of the operation that it is in
  const config::ProgramFormat& format_;
  const bool retracts_;
  std::vector<std::string_view> missing_;
  std::array<char, 5> letters_;
  std::vector<std::string> clamps_, start_, end_;  ///< the profile's own lines
  std::size_t started_ = 0;                        ///< lines of `start_` that have come
  /// A line that waits until as many as the profile's end has stand behind it, or the end.
  struct Waiting {
    std::string line;
    std::uint64_t number;
  };
  std::deque<Waiting> waiting_;
  std::uint64_t count_ = 0, line_ = 0;  ///< of lines; the one that is looked at
  std::string own_retract_, room_;
  std::vector<int> registers_;  ///< that the header names
  int offset_ = 0, tool_ = 0;
  int arc_plane_ = 17;
  /// Letters of axes, by place in `letters_`, that have been sent to a place since the last tool change.
  std::array<bool, 5> placed_{};
  std::array<double, 5> words_{};  ///< the last word of each
  /// Where the rotaries stand in each plane that has come, in the order of their own work offsets.
  std::vector<std::array<double, 2>> offset_planes_;
  bool preset_cycle_ = false;  ///< the line before calls a TNC's preset
  bool keeps_tool_ = false;    ///< the operation has the tool of the one before
  bool next_tool_ = false;     ///< the header's lines of another tool have come, its change has not
  bool changed_ = false;       ///< the tool that is selected has been changed for, or stopped for
  bool linear_rotaries_ = false;
  bool percent_ = false, opened_ = false, begun_ = false, closed_ = false;
  bool length_on_ = false, relative_ = false, tcp_place_ = false;
  bool names_part_ = false, posted_ = false, length_called_ = false, inverse_ = false, tcp_ = false,
       frames_dropped_ = false, moved_ = false, retracted_ = false, ended_ = false, spindle_ = false,
       smooth_ = false, plane_ended_ = false, plane_ = false,
       in_planes_ = false;  ///< a plane is in force; the header says that all moves are in one
};

}  // namespace tiltfeed::sim
