#pragma once
// The dialects of program text as one table of words and rules. Words in braces are filled in: {name},
// {number}, {offset}, {tool}, {register} (of its length), {edge} (likewise; 1 where none
// is stated), {cutter} (of its radius), {rpm}, {turn} (3 or 4), {seconds}, {milliseconds}, {tolerance},
// {angles} and {side} of a tilted plane, {swivel} (the name of the swivel data in quotes),
// {rotaries} (",A,C" of those that the machine has), {in_degrees} and {at_radius} (FGREF of each). "|" ends a
// line; a line that asks for what there is not is left out.

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/program_format.h"

namespace tiltfeed::daemon {

enum class Numbering {
  kOptional,  ///< N words where the profile wants them
  kN,         ///< N words always
  kPlain,     ///< a number without a letter, always
};

/// Where the words of cutter compensation stand.
enum class Sides {
  kLine,    ///< in a line of their own
  kBefore,  ///< in the next block that moves X or Y, before its axis words
  kBehind,  ///< in that block, behind them
};

/// Properties of programs by any row: 1 The axis words are read back to the last digit, by two readers that
/// share nothing. 2 F is what the feed mode asks for: within kFeedError, or the last of `feed_decimals`.
/// 3 The first block under TCP states all five words. 4 A numbered line has one number, a step above that of
/// the line before; after `last_number` they begin anew.
struct DialectTable {
  config::Dialect dialect;
  // Lines
  const char *comment_open, *comment_close;
  Numbering numbering;
  const char* unnumbered;  ///< lines that begin with one of these have no number
  std::uint64_t first_number, last_number;
  const char* block_end;  ///< what closes each numbered line
  // Words
  bool point;                                ///< whole numbers keep their decimal point (X10. is not X10)
  bool plus;                                 ///< axis words have a sign always
  bool modal_motion;                         ///< the motion word stays in force
  const char *rapid, *feed;                  ///< motion words
  const char *first_end, *rapid_end;         ///< words behind the axes: of the first block, of each rapid
  int feed_decimals;                         ///< of F per minute, at most
  const char *shorter_open, *shorter_close;  ///< round the number of a rotary word that goes the shorter way
  const char *shorter_on, *shorter_off;      ///< lines between which rotary words go the shorter way
  // Parts of the program
  // `setup` ends what others left in force, too, where the control does so without motion: tilted planes,
  // rotation, TCP.
  const char *mm = "G21", *inch = "G20";  ///< {units}
  const char *open, *setup, *tool, *spindle, *spindle_off, *flood, *mist, *coolant_off;
  const char *cutter_left, *cutter_right, *cutter_off;  ///< the control's cutter compensation
  Sides sides = Sides::kLine;
  bool shifts_in_zx = false, shifts_in_yz = false;  ///< under G18, under G19, its tool length as it was
  const char *length_in_tool, *length_alone;  ///< what to do with the control's own length, for a comment
  const char *length, *tcp_length;            ///< words in front of the axes of the first block
  const char* length_off;                     ///< lines that end that, once the tool is retracted
  const char* plane_off;  ///< lines after the first of these that end a tilted plane and a rotation
  // Lines that begin a tilted plane, the rotaries at its place, and that end it, the tool retracted.
  const char *plane_on, *plane_done;
  const char* plane_offset = "";      ///< lines that call a plane's own work offset before it
  const char* preselect = "T{next}";  ///< line that makes the next tool ready
  const char* edge = "";         ///< line that calls the tool's length anew behind a retract that ends it
  const char *tcp_on, *tcp_off;  ///< lines; it ends before the tool is retracted
  const char* tcp_frame = "";    ///< parameters that a program under TCP takes for granted, for a comment
  const char *inverse_on, *per_minute_on, *degrees, *radius;  ///< feed modes and what F measures
  // Lines of the high-speed function: {mode}, {within} (of the unit), {leans} (degrees).
  const char *smooth_on = "", *smooth_off = "";
  const char *exact, *blend, *dwell, *stop, *optional_stop, *retract, *end;
  // Arcs. `pole`: a line in front with the centre, absolute, by these letters; no letters: I J K from the
  // start stand in the block.
  bool arc_planes = false;  ///< in Z X and Y Z, too, under G18 and G19, the tool's length as it was
  const char *clockwise = "G2", *clockwise_end = "", *counter = "G3", *counter_end = "";  ///< round the axes
  const char *pole = "", *pole_letters = "";
};

const DialectTable& table_of(config::Dialect dialect);

/// What fills the braces, by name.
using Filling = std::vector<std::pair<std::string_view, std::string>>;
/// The lines of a template.
std::vector<std::string> filled(std::string_view lines, const Filling& filling);
/// The whole of a template that has one line at most.
std::string filled_line(std::string_view words, const Filling& filling);

/// The words that select a work offset, as config::most_work_offsets() numbers them: G54, G54.1 P3, or a
/// Heidenhain preset number. Requires: the control has so many.
std::string work_offset_word(config::Dialect dialect, int offset);
/// A program's name as a Heidenhain control takes it: [A-Z0-9_-], not empty.
std::string program_name(std::string_view name);

}  // namespace tiltfeed::daemon
