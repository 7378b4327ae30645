#pragma once
// How program text looks: the dialects, and what a machine's profile and a job may state of it.

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kinematics/machine/machine.h"

namespace tiltfeed::config {

/// The controls whose program text can be written and read. Their words: daemon/post/dialect.cpp.
enum class Dialect { kRs274, kGrbl, kFanuc, kHaas, kSiemens, kHeidenhain, kHeidenhainIso };

struct DialectName {
  Dialect dialect;
  const char* name;     ///< in profiles and on the command line
  const char* control;  ///< for people
  int most_decimals;    ///< that the control reads
  // Why the control does not turn a rotary the shorter way, or by the word's sign; nullptr: it does, told by
  // a word of the program or by a parameter that the profile repeats.
  const char *no_shortest, *no_signed;
};
inline constexpr std::array<DialectName, 7> kDialects{{
    {Dialect::kRs274, "rs274", "LinuxCNC and other RS274/NGC controls", 6,
     "LinuxCNC has no word and no setting for the shorter way, its WRAPPED_ROTARY is signed", nullptr},
    {Dialect::kGrbl, "grbl", "Grbl, grblHAL, FluidNC", 4, "Grbl counts turns", "Grbl counts turns"},
    // Parameter 1008: ROA=0 counts turns; ROA=1 is modulo, with RAB=0 the shorter way, with RAB=1 by the
    // sign.
    {Dialect::kFanuc, "fanuc", "Fanuc 30i and relatives; TCP is G43.4", 3, nullptr, nullptr},
    {Dialect::kHaas, "haas", "Haas NGC; TCP is G234", 3,
     "no word of a Haas program tells the control to take the shorter way",
     "a Haas reads the sign as part of the place"},
    {Dialect::kSiemens, "siemens", "Sinumerik 840D; TCP is TRAORI", 6, nullptr,
     "a Sinumerik reads the sign as part of the place"},
    {Dialect::kHeidenhain, "heidenhain", "Heidenhain iTNC and TNC, conversational; TCP is M128", 4, nullptr,
     "a TNC reads the sign as part of the place"},
    {Dialect::kHeidenhainIso, "heidenhain_iso", "Heidenhain iTNC and TNC, DIN/ISO; TCP is M128", 4, nullptr,
     "a TNC reads the sign as part of the place"},
}};

enum class FeedMode {
  kInverseTime,  ///< G93: F = 1 / time of the block
  kPerMinute,    ///< G94: F = way / time, the way as FeedMeasure says
};

/// What way a control means by an F per minute in a block that also turns a rotary.
enum class FeedMeasure {
  kXyz,      ///< of X Y Z alone; of the rotaries in degrees where X Y Z stand still
  kDegrees,  ///< the root of the sum of all squares, a degree counting as a mm
  kRadius,   ///< likewise, an angle counting as its arc at a reference radius
};

enum class PathControl {
  kControl,  ///< no word: as the control stands
  kExact,    ///< G61: through every point
  kBlend,    ///< G64 P between blocks that turn no rotary: it bounds X Y Z alone; G61 elsewhere
};

/// How the program text of this control looks.
struct ProgramFormat {
  Dialect dialect = Dialect::kRs274;
  bool inches = false;      ///< linear words and F per minute; everything else is in mm
  int linear_decimals = 4;  ///< of the unit
  int rotary_decimals = 4;
  // That a fine tolerance may ask for: what the profile states, else what the control reads.
  int most_linear_decimals = 4, most_rotary_decimals = 4;
  int max_line_length = 79;          ///< bytes, without line end
  bool line_numbers = false;         ///< N words; Heidenhain text always has numbers
  double max_inverse_time = 100000;  ///< largest F in G93, 1/min
  bool tcp = false;  ///< the control keeps the tool centre point: X Y Z are the tip's in the part's frame
  double tcp_start_below = 50.0;  ///< the upper end of Z's travel, mm: where begins_at_home() lets it begin
  /// Where the rotaries stand in every cut, the program is in the control's tilted planes, tcp or not.
  bool tilted_planes = false;
  std::string swivel_data;  ///< kSiemens: the name that CYCLE800 calls; empty: the only data that there are
  FeedMode feed_mode = FeedMode::kInverseTime;  ///< without TCP
  FeedMeasure feed_measure = FeedMeasure::kXyz;
  double feed_radius = 0.0;    ///< for kRadius, mm
  double max_feed = 100000.0;  ///< largest F per minute, mm/min
  int line_number_step = 1;
  bool crlf = false;     ///< lines end in CR LF
  bool percent = false;  ///< a line % before and after the program
  int max_blocks = 0;    ///< motion blocks that the control takes; 0: no limit
  int max_bytes = 0;     ///< of the whole file; 0: no limit
  PathControl path_control = PathControl::kControl;
  double blend_tolerance = 0.0;  ///< for kBlend, mm: what corners may be rounded off by; else 0
  std::string retract;  ///< line before a tool change and at the end; "default": the dialect's; "none"
  std::vector<std::string> start, end;  ///< lines before the first motion and before the program's end
  std::string clamp_tilt, unclamp_tilt, clamp_rotary, unclamp_rotary;  ///< words, empty: none
  bool preselects = false;              ///< the next tool is selected behind the change for the one at work
  std::string through_on, through_off;  ///< words of the coolant through the spindle, empty: none
};

/// Of any control.
inline constexpr int kMostWorkOffsets = 999;

/// The format that a dialect has where a profile states nothing.
ProgramFormat usual_format(Dialect dialect);
const DialectName& name_of(Dialect dialect);
/// The format with so many decimals, up to the most, that rounding the words takes kRoundingShare of the
/// tolerances (mm, degrees) at most.
ProgramFormat fine_enough(ProgramFormat format, double tolerance, double axis_tolerance);
inline constexpr double kRoundingShare = 0.1;
/// Whether the control has a tool centre point function that we know the words of.
constexpr bool has_tcp(Dialect d) { return d != Dialect::kRs274 && d != Dialect::kGrbl; }
/// Whether the control has a tilted working plane that we know the words of.
constexpr bool has_tilted_planes(Dialect d) { return d != Dialect::kRs274 && d != Dialect::kGrbl; }
/// Whether its plane turns with the table and is stated by no angles (Haas G254): its axes stay the
/// machine's.
constexpr bool plane_follows_table(Dialect d) { return d == Dialect::kHaas; }
/// Why programs for this machine cannot be in tilted planes; nothing: they can.
std::optional<std::string> no_planes(const MachineModel& machine, const ProgramFormat& format);
/// The format of a program in tilted planes: the control adds the tool's length along its axis, and F is the
/// tip's in mm/min.
ProgramFormat in_tilted_planes(ProgramFormat format);
/// Whether the control may count X Y Z from the table as it stands where TCP begins (Fanuc A-79348E): TCP
/// begins with the table at home, where both readings are one, and the table turns behind it.
constexpr bool begins_at_home(Dialect d) { return d == Dialect::kFanuc || d == Dialect::kHaas; }
/// Whether the control has G93.
constexpr bool has_inverse_time(Dialect d) {
  return d != Dialect::kHeidenhain && d != Dialect::kHeidenhainIso;
}

/// How many work offsets a program of this control can call. The first six are G54 to G59; then come G59.1 to
/// G59.3 (LinuxCNC), G54.1 P1 to P300 (Fanuc), G154 P1 to P99 (Haas). Siemens has G54 to G57 and G505 to
/// G599, Heidenhain presets by number.
constexpr int most_work_offsets(Dialect d) {
  switch (d) {
    case Dialect::kRs274:
      return 9;
    case Dialect::kGrbl:
      return 6;
    case Dialect::kFanuc:
      return 306;
    case Dialect::kHaas:
      return 105;
    case Dialect::kSiemens:
      return 99;
    case Dialect::kHeidenhain:
    case Dialect::kHeidenhainIso:
      break;
  }
  return kMostWorkOffsets;
}

/// The program's unit of length, mm.
constexpr double unit_of(const ProgramFormat& format) { return format.inches ? 25.4 : 1.0; }
/// The place, mm, that the word printed for `mm` says.
double printed_place(const ProgramFormat& format, double mm);

/// Why programs of this control cannot say rotary words that count so; nullptr: they can.
const char* refusal_of(Dialect dialect, RotaryWord word);

/// Whether files of this control may stand between two %.
constexpr bool has_percent(Dialect d) {
  return d == Dialect::kRs274 || d == Dialect::kGrbl || d == Dialect::kFanuc || d == Dialect::kHaas;
}

enum class Coolant { kOff, kFlood, kMist, kThrough };

/// What the control's high-speed function (G5.1, G187, CYCLE832, cycle 32) is told that the work is.
enum class Smoothing { kNone, kRough, kSemi, kFinish };
/// By its word in a job: none, rough, semi, finish.
std::optional<Smoothing> smoothing_of(const std::string& word);
/// Of ProgramData::smoothing_tolerance, mm.
inline constexpr double kLeastSmoothing = 0.001, kMostSmoothing = 1.0;
/// Whether the control has such a function that we know the words of.
constexpr bool has_smoothing(Dialect d) { return d != Dialect::kRs274 && d != Dialect::kGrbl; }

/// What a job states of its program.
struct ProgramData {
  int number = 1;       ///< O word, Fanuc and Haas
  int tool = 0;         ///< of the tool change; 0: no tool change, the tool is in the spindle
  int work_offset = 1;  ///< 1 is G54, up to most_work_offsets(); the preset's number in Heidenhain text
  Coolant coolant = Coolant::kOff;
  int length_register = 0;  ///< H (D of a Siemens) of the tool's length; 0: the tool's number
  Smoothing smoothing = Smoothing::kNone;
  double smoothing_tolerance = 0.0;  ///< what the control may leave the path by with it, mm; else 0
  /// What arcs (G2, G3) may leave the straight blocks by that they stand for, mm; 0: no arcs.
  double arc_tolerance = 0.0;
  /// Each tilted plane has a work offset of its own, from `work_offset` on; all are at part zero.
  bool plane_offsets = false;
};

/// Of ProgramData::arc_tolerance, mm.
inline constexpr double kLeastArcTolerance = 0.0005, kMostArcTolerance = 1.0;

/// What of it this control cannot be told: keys of the section `program`, and why.
/// `profile`: the file of it, for messages.
std::vector<std::pair<const char*, std::string>> not_of_control(const ProgramData& data,
                                                                const ProgramFormat& format,
                                                                const std::string& profile);
/// That and what to do.
std::string no_through_coolant(const std::string& profile);

}  // namespace tiltfeed::config
