#include "sim/control/frame_rules.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "sim/control/plane_words.h"
#include "sim/control/smoothing_words.h"

namespace tiltfeed::sim {
namespace {

using config::Dialect;
using Wrong = Frame::Wrong;

/// The whole number behind `words`; -1: the line has none there.
int number_after(std::string_view line, std::string_view words) {
  const std::size_t at = line.find(words);
  if (at == line.npos) return -1;
  const std::string digits(line.substr(at + words.size(), 8));
  char* end = nullptr;
  const long number = std::strtol(digits.c_str(), &end, 10);
  return end == digits.c_str() ? -1 : static_cast<int>(number);
}

}  // namespace

std::string_view Frame::closing() const {
  if (format_.dialect == Dialect::kHeidenhain) return "END PGM";
  if (format_.dialect == Dialect::kHeidenhainIso) return "its second % line";
  return format_.percent ? "a second %" : "";
}

/// The lines that a control knows a file of programs by.
void Frame::opening(std::string_view line) {
  if (line == "%" && !std::exchange(percent_, true) && counts_length()) return;
  begun_ = true;
  if (format_.dialect == Dialect::kHeidenhain)
    opened_ = line.starts_with("BEGIN PGM") && line.ends_with(format_.inches ? " INCH" : " MM");
  else if (format_.dialect == Dialect::kHeidenhainIso)
    opened_ = line.front() == '%' && says(line, format_.inches ? "G70" : "G71");
  else
    opened_ = line.front() == 'O' || line.front() == ':' || !counts_length();
}

Frame::Wrong Frame::not_opened() const {
  if (format_.percent && !percent_)
    return "the file does not begin with %: such a control passes over its first line, or takes none of it "
           "(the profile's program.percent)";
  if (opened_) return std::nullopt;
  if (format_.dialect == Dialect::kHeidenhain)
    return "the program does not begin with BEGIN PGM and the profile's unit: the control takes no such "
           "file, or in the other unit";
  if (format_.dialect == Dialect::kHeidenhainIso)
    return "the program does not begin with % and the profile's unit: the control takes no such file, or in "
           "the other unit";
  return "the program has no O number in front: the control does not take it, or under another number";
}

/// Where TCP begins every word is stated: what is left out stays where the control has the tip, which its
/// parameters and its registers decide.
Frame::Wrong Frame::tcp_begins(const ControlWords& words) {
  const bool in_block = words.has_g(434) || words.has_g(2340);
  if (!in_block && !tcp_place_) return std::nullopt;
  const auto missing = std::find_if(letters_.begin(), letters_.end(),
                                    [&](char letter) { return letter != kNoLetter && !words.has(letter); });
  const bool all_missing =
      std::none_of(letters_.begin(), letters_.end(), [&](char letter) { return words.has(letter); });
  if (!in_block && all_missing) return std::nullopt;
  tcp_place_ = false;
  if (missing == letters_.end()) return std::nullopt;
  return std::string("TCP begins in a block without ") + *missing + ": where the tip is then is not known";
}

/// "TILTFEED operation 2 of 3 NAME": from there on the next operation's job holds.
Frame::Wrong Frame::operation_begins(std::string_view text) {
  if (!marked_) return "an operation of a job begins, and the job has no list of operations";
  if (begun_operations_ == operations_.size())
    return "an operation begins behind the last one that the job has";
  const config::Job& next = operations_[begun_operations_];
  const config::OperationName& wanted = next.operation;
  const std::string mark = "operation " + std::to_string(wanted.number) + " of " +
                           std::to_string(wanted.count) + " " + wanted.name;
  if (!text.starts_with(mark) || text.substr(mark.size()).find_first_not_of(" )*\r") != text.npos)
    return "another operation begins here than the job has next, " + mark;
  if (begun_operations_ > 0 && retracts_ && !retracted_)
    return "an operation begins before the tool is retracted along the machine's Z";
  keeps_tool_ = begun_operations_ > 0 && next.program.tool == job_->program.tool;
  ++begun_operations_;
  job_ = &next;
  return std::nullopt;
}

/// What every header of a posted program says, and the register in ", H4 too".
Frame::Wrong Frame::header(std::string_view text) {
  const std::string_view said = text.substr(text.find("TILTFEED ") + std::string_view("TILTFEED ").size());
  if (said.starts_with("operation ")) return operation_begins(said);
  names_part_ = names_part_ || text.find("TILTFEED part ") != text.npos;
  posted_ = posted_ || (names_part_ && text.find("TILTFEED blocks ") != text.npos);
  if (text.find("TILTFEED tool length") == text.npos) return std::nullopt;
  next_tool_ = moved_ && !keeps_tool_;
  in_planes_ = text.find(", planes take the control's") != text.npos;
  for (const std::string_view letter : {", H", ", D"})
    if (const int number = number_after(text, letter); number > 0) registers_.push_back(number);
  return std::nullopt;
}

Frame::Wrong Frame::offset(std::string_view line, const ControlWords& words) {
  const int before = offset_;
  if (tnc()) {
    const bool called = std::exchange(preset_cycle_, line.starts_with("CYCL DEF 247"));
    const int preset = number_after(line, "Q339=");
    if (preset >= 0 && !called && !line.starts_with("G247")) return "a preset's number without its cycle";
    if (preset >= 0) offset_ = preset;
  } else {
    for (std::size_t i = 0; i < words.g_count; ++i) {
      const int code = words.g[i] / 10;
      const int tenths = words.g[i], p = words.has('P') ? static_cast<int>(words['P']) : 0;
      int called = 0;
      if (code >= 54 && code <= 59) called = code - 53;
      if (tenths >= 591 && tenths <= 593) called = 6 + tenths % 10;
      if (format_.dialect == Dialect::kSiemens && code >= 505 && code <= 599) called = code - 500;
      if (tenths == 541 || tenths == 1540) {
        if (p < 1) return "a further work offset is called without P, its number";
        called = 6 + p;
      }
      if (called > 0) offset_ = called, frames_dropped_ = false;
    }
  }
  if (job_->program.plane_offsets) {
    if (offset_ == before || before == 0) return std::nullopt;
    if (plane_) return "another work offset is called in a tilted plane";
    if (std::any_of(placed_.begin(), placed_.end(), [](bool placed) { return placed; }))
      return "a plane's work offset is called behind the way of the axes to it, which goes by the one before";
    return std::nullopt;
  }
  if (offset_ == 0 || offset_ == job_->program.work_offset) return std::nullopt;
  return "work offset " + std::to_string(offset_) + " is called, the job's program.work_offset is " +
         std::to_string(job_->program.work_offset);
}

Frame::Wrong Frame::length_register(const ControlWords& words) {
  const bool edge = format_.dialect == Dialect::kSiemens;
  const char letter = edge ? 'D' : 'H';
  if (tnc() || !words.has(letter)) return std::nullopt;
  const bool jobs = job_->program.length_register > 0 && tool_ == job_->program.tool;
  const int stated = static_cast<int>(words[letter]),
            wanted = jobs ? job_->program.length_register : (edge ? 1 : tool_);
  const bool named = std::find(registers_.begin(), registers_.end(), stated) != registers_.end();
  const bool in_force = edge || words.has_g(430) || words.has_g(434) || words.has_g(2340);
  if (edge || in_force) length_called_ = stated != 0;
  if (stated == 0 || wanted == 0 || stated == wanted || (named && !jobs)) return std::nullopt;
  return std::string("the length of register ") + letter + std::to_string(stated) +
         " is called, that of the tool is " + letter + std::to_string(wanted);
}

/// The places of the rotaries have the work offsets from the job's on, in the order in which they come first.
Frame::Wrong Frame::plane_offset() {
  constexpr double kSamePlace = 1e-4;  // degrees
  const std::array<double, 2> at{words_[3], words_[4]};
  const auto same = [&](const std::array<double, 2>& place) {
    return std::abs(std::remainder(place[0] - at[0], 360.0)) < kSamePlace &&
           std::abs(std::remainder(place[1] - at[1], 360.0)) < kSamePlace;
  };
  const auto known = std::find_if(offset_planes_.begin(), offset_planes_.end(), same);
  const int own = job_->program.work_offset + static_cast<int>(known - offset_planes_.begin());
  if (known == offset_planes_.end()) offset_planes_.push_back(at);
  if (offset_ == own) return std::nullopt;
  return "work offset " + std::to_string(offset_) + " is in force where a tilted plane begins whose own is " +
         std::to_string(own) + " (program.plane_offsets)";
}

/// CYCLE800 reckons with the axes of the swivel data that it calls.
Frame::Wrong Frame::swivel_data(std::string_view line) const {
  const auto name = swivel_name(line);
  if (name && *name == format_.swivel_data) return std::nullopt;
  return "CYCLE800 calls the swivel data \"" + std::string(name.value_or("")) +
         "\", the profile's program.swivel_data is \"" + format_.swivel_data + "\"";
}

/// A tilted plane begins before the tool's length counts, where a control nests the two, and ends when the
/// tool is retracted.
Frame::Wrong Frame::planes(std::string_view line, const ControlWords& words) {
  const bool cycle = line.starts_with("CYCLE800("), plane = tnc() && line.starts_with("PLANE ");
  const bool ends = words.has_g(690) || words.has_g(2550) || line == "CYCLE800()" ||
                    (plane && line.starts_with("PLANE RESET"));
  const bool begins = !ends && (words.has_g(682) || words.has_g(2540) || cycle || plane);
  if (!ends && !begins) return std::nullopt;
  if (begins && cycle)
    if (auto wrong = swivel_data(line)) return wrong;
  if (begins && job_->program.plane_offsets)
    if (auto wrong = plane_offset()) return wrong;
  const bool in_force = std::exchange(plane_, begins);
  const bool length_on = length_on_ && counts_length();
  if (ends && in_force) placed_ = {};
  const bool known_off = plane_ended_;
  plane_ended_ = ends && (words.has_g(2550) || line == "CYCLE800()");
  const bool states_no_end = format_.dialect == Dialect::kHaas || format_.dialect == Dialect::kSiemens;
  if (begins && states_no_end && !known_off && !in_force)
    return "a tilted plane begins, and one that others may have left on is not ended before";
  if (begins && in_force) return "a tilted plane begins while another is in force";
  if (length_on) return "a tilted plane begins or ends with the tool's length in force: G49 is missing";
  if (retracts_ && !retracted_ && (begins || in_force))
    return "a tilted plane begins or ends before the tool is retracted along the machine's Z";
  return std::nullopt;
}

/// The high-speed function is the job's, and leaves the path by no more than the job lets it.
Frame::Wrong Frame::smoothing(std::string_view line) {
  if (!smooths(line, format_.dialect)) return std::nullopt;
  smooth_ = smoothing_after(line, format_.dialect).value_or(smooth_);
  const bool wanted = job_->program.smoothing != config::Smoothing::kNone;
  if (smooth_ && !wanted) return "the high-speed function is on, and the job's program.smoothing is none";
  if (format_.dialect == Dialect::kFanuc && line != "G5.1 Q1" && line != "G5.1 Q0")
    return "G5.1 with other words than Q1 and Q0";
  constexpr double kLastDigit = 1e-9, kLeastLean = 1e-4;  // a lean is printed as one digit at least
  const double most = job_->program.smoothing_tolerance / config::unit_of(format_) + kLastDigit;
  if (const auto within = smoothing_within(line, format_.dialect); within && *within > most)
    return "the control may leave the path by more than the job's program.smoothing_tolerance_mm";
  if (const auto mode = is_smoothing_mode(line, format_.dialect, job_->program.smoothing); mode && !*mode)
    return "the high-speed function is called for other work than the job's program.smoothing";
  // The half of it is for what the tool's end moves: of the job's tool; others have another length.
  const bool jobs = tool_ == job_->program.tool && job_->setup.tool_length > 0.0;
  const double half = 0.5 * job_->program.smoothing_tolerance;
  const double leans = std::max(Angle::from_radians(half / job_->setup.tool_length).degrees(), kLeastLean);
  if (const auto stated = smoothing_leans(line, format_.dialect);
      jobs && stated && *stated > leans + kLastDigit)
    return "the control may lean the tool by more than half of the job's program.smoothing_tolerance_mm at "
           "its "
           "end: " +
           decimal(*stated, 4) + " degrees are stated, " + decimal(leans, 4) + " are left to it";
  return std::nullopt;
}

/// The plane of arcs, or of cutter compensation, is the usual one where a tool's length begins to count: some
/// controls add it along another axis else.
Frame::Wrong Frame::arc_plane(const ControlWords& words) {
  for (const int plane : {17, 18, 19})
    if (words.has_g(plane * 10)) arc_plane_ = plane;
  const bool counts = words.has_g(430) || words.has_g(434) || words.has_g(2340) || words.has_m(6);
  if (!counts || arc_plane_ == 17 || tnc()) return std::nullopt;
  return "G" + std::to_string(arc_plane_) + " is in force where a tool's length begins: G17 is lost";
}

/// A move to a place in machine coordinates is the profile's retract: another place is in the way of
/// something, or over the end of a travel.
Frame::Wrong Frame::retract(std::string_view line, const ControlWords& words) {
  retracted_ = retracted_ || words.has('Z');
  if (!posted_) return std::nullopt;
  if (tcp_) return "a move in machine coordinates comes before TCP is ended";
  if (format_.retract != "default") {
    if (line == own_retract_) return std::nullopt;
    return "a move in machine coordinates that is not the profile's program.retract";
  }
  if (words.named("SUPA") && words.has('Z') && !(words.has('D') && words['D'] == 0.0))
    return "a retract without D0: the tool's length counts there, too";
  const bool others = std::any_of(letters_.begin(), letters_.end(), [&](char letter) {
    return letter != kNoLetter && letter != 'Z' && words.has(letter);
  });
  const double place = tnc() ? -1.0 : 0.0;
  if (others || !words.has('Z') || words['Z'] != place || words.has_m(92))
    return "a retract moves Z alone, to " + std::to_string(static_cast<int>(place)) +
           " in machine coordinates; this line goes elsewhere";
  return std::nullopt;
}

Frame::Wrong Frame::tool(std::string_view line, const ControlWords& words) {
  const bool call = format_.dialect == Dialect::kHeidenhain;
  const int number = call             ? number_after(line, "TOOL CALL ")
                     : words.has('T') ? static_cast<int>(std::clamp(words['T'], 0.0, 1e6))
                                      : -1;
  const bool stands = std::none_of(placed_.begin(), placed_.end(), [](bool placed) { return placed; });
  // Behind a change the next tool is only made ready.
  if (number < 0 || words.has_g(510) || (format_.preselects && changed_ && stands)) return std::nullopt;
  const bool length_left = std::exchange(length_on_, false) && counts_length();
  if (tool_ == 0 && job_->program.tool > 0 && number != job_->program.tool)
    return "tool " + std::to_string(number) + " is called, the job's program.tool is " +
           std::to_string(job_->program.tool);
  tool_ = number, length_called_ = false;
  changed_ = tnc();  // there the call is the change
  if (changed_) next_tool_ = false;
  placed_ = {};  // a changer may have moved the axes
  if (retracts_ && !retracted_) return "a tool change without a retract along the machine's Z before it";
  if (length_left) return "a tool change with the length of the tool before in force: G49 is missing";
  return std::nullopt;
}

/// Before Z moves from a retract the tool is there, and the other axes have been sent to its place.
Frame::Wrong Frame::goes_down(const ControlWords& words) const {
  if (!words.has('Z')) return std::nullopt;
  if (marked_ && tool_ != job_->program.tool)
    return "Z moves with tool " + std::to_string(tool_) + ", the operation has tool " +
           std::to_string(job_->program.tool);
  if (tool_ > 0 && next_tool_) return "Z moves before the change to the next tool";
  if (tool_ > 0 && !changed_)
    return std::string("tool ") + std::to_string(tool_) +
           " is selected, and the change of tools is missing (" +
           (format_.dialect == Dialect::kGrbl ? "M0" : "M6") + ")";
  if (wants_length() && !length_called_) return "Z moves before the register of the tool's length is called";
  if ((tcp_ || plane_) && format_.dialect == Dialect::kSiemens && !length_called_)
    return "Z moves before the tool's length is called again (D): the retract has ended it";
  if (tcp_ && format_.dialect == Dialect::kSiemens && !linear_rotaries_)
    return "TRAORI without ORIMKS ORIAXES: how the rotaries turn within a block is the machine's setting";
  if (job_->program.smoothing != config::Smoothing::kNone && !smooth_)
    return "Z moves before the control is told the job's program.smoothing";
  if (in_planes_ && !plane_) return "Z moves before the tilted plane is called";
  if (!retracts_ || !retracted_) return std::nullopt;
  for (const std::size_t i : {std::size_t{3}, std::size_t{4}, std::size_t{0}, std::size_t{1}})
    if (letters_[i] != kNoLetter && !placed_[i])
      return std::string("Z moves from the retract before ") + letters_[i] + " is at its place";
  return std::nullopt;
}

Frame::Wrong Frame::first_move() const {
  if (auto wrong = not_opened()) return wrong;
  if (!missing_.empty())
    return "the first move comes before " + std::string(missing_.front()) +
           ", which every posted program has";
  if (tool_ == 0 && job_->program.tool > 0) return "the first move comes before a tool is called";
  if (offset_ == 0) return "the first move comes before a work offset is called";
  if (retracts_ && !retracted_) return "the first move comes before a retract along the machine's Z";
  if (started_ < start_.size())
    return "the first move comes before \"" + start_[started_] +
           "\" of the profile's program.start, which stands behind the post's own lines";
  return std::nullopt;
}

/// All that the post says before the profile's start lines has been said. A line that is equal to one of
/// these is the post's own before.
bool Frame::set_up() const {
  const bool tool_there = tool_ > 0 ? changed_ && (length_called_ || counts_length() || !wants_length())
                                    : job_->program.tool == 0;
  return missing_.empty() && offset_ != 0 && !relative_ && tool_there && (retracted_ || !retracts_);
}

/// All that the post says before the profile's end lines has been said.
bool Frame::left() const {
  const bool length_left = length_on_ && counts_length();
  return moved_ && !inverse_ && !relative_ && !tcp_ && !plane_ && !length_left && (retracted_ || !retracts_);
}

Frame::Wrong Frame::at_end() const {
  if (marked_ && begun_operations_ < operations_.size())
    return "the program ends, and the operation " + operations_[begun_operations_].operation.name +
           " of the job has not begun";
  if (retracts_ && !retracted_) return "the program ends without a retract along the machine's Z";
  if (inverse_) return "the program ends with G93 in force";
  if (relative_) return "the program ends with G91 in force: the next words would be taken as ways";
  if (arc_plane_ != 17)
    return "the program ends with G" + std::to_string(arc_plane_) + " in force: G17 is lost";
  if (smooth_ && job_->program.smoothing != config::Smoothing::kNone)
    return "the program ends with the job's program.smoothing in force";
  if (plane_) return "the program ends with a tilted plane in force: the next words would be taken as in it";
  if (length_on_ && counts_length())
    return "the program ends with the tool's length in force: G49 is missing, and the next tool has another";
  return std::nullopt;
}

}  // namespace tiltfeed::sim
