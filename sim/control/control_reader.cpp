#include "sim/control/control_reader.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <utility>

#include "sim/gcode/gcode_words.h"
#include "sim/gcode/lines.h"

namespace tiltfeed::sim {
namespace {

// Codes that move nothing and change no meaning of later words, in tenths.
constexpr std::array kQuietG{170, 210,  400,  430,  490,  540,  550,  560,  570,  580, 590, 600, 610,
                             611, 640,  641,  642,  643,  644,  645,  690,  710,  800, 900, 940, 970,
                             930, 5000, 5050, 5060, 5070, 5080, 5090, 7100, 2470, 280, 530, 40};
// The third decimal of a word rounds by no more, degrees.
constexpr double kAtHome = 5.1e-4;
// Names that end what others may have left on, and words of motion without a number.
constexpr std::array<std::string_view, 11> kSiemensNames{
    "TRAORI", "TRAFOOF", "TOROTOF", "PAROTOF", "TRANS", "ROT", "ORIMKS", "ORIAXES", "SUPA", "SOFT", "BRISK"};
constexpr std::array<std::string_view, 6> kDialogueNames{"FMAX", "L", "C", "CC", "DR+", "DR-"};

template <class List, class Item>
bool holds(const List& list, const Item& item) {
  return std::find(std::begin(list), std::end(list), item) != std::end(list);
}

/// G53.1 and G254, G255: what they mean is in planes().
bool of_planes(int tenths, config::Dialect dialect) {
  if (dialect == config::Dialect::kFanuc) return tenths == 531;
  return dialect == config::Dialect::kHaas && (tenths == 2540 || tenths == 2550);
}

/// G54.1 P, G154 P, G59.1, G505: offsets move nothing here; program_frame.h holds which one is called.
bool further_offset(int tenths, config::Dialect dialect) {
  if (dialect == config::Dialect::kFanuc) return tenths == 541;
  if (dialect == config::Dialect::kHaas) return tenths == 1540;
  if (dialect == config::Dialect::kRs274) return tenths >= 591 && tenths <= 593;
  return dialect == config::Dialect::kSiemens && tenths >= 5050 && tenths <= 5990;
}

std::string code_text(char letter, int code) {
  std::string text(1, letter);
  text += std::to_string(letter == 'G' ? code / 10 : code);
  if (letter == 'G' && code % 10 != 0) text += "." + std::to_string(code % 10);
  return text;
}

}  // namespace

ControlReader::ControlReader(const config::MachineProfile& machine, const Setup& setup)
    : dialect_(machine.format.dialect),
      unit_(machine.format.inches ? 25.4 : 1.0),
      counts_points_(dialect_ == config::Dialect::kFanuc || dialect_ == config::Dialect::kHaas),
      model_(machine.model),
      frames_(machine.model, setup),
      angle_decimals_(machine.format.rotary_decimals) {
  known_[3] = !model_.tilt.present;
  known_[4] = !model_.rotary.present;
  const config::ProgramFormat& f = machine.format;
  const auto bare = [&](const std::string& text) { return std::string(bare_line(text, dialect_, room_)); };
  own_lines_ = {bare(f.clamp_tilt),     bare(f.unclamp_tilt), bare(f.clamp_rotary),
                bare(f.unclamp_rotary), bare(f.through_on),   bare(f.through_off)};
  for (const auto* lines : {&f.start, &f.end})
    for (const std::string& text : *lines) own_lines_.push_back(bare(text));
  if (f.retract != "default" && f.retract != "none") own_retract_ = bare(f.retract);
}

bool ControlReader::own_line(std::string_view line) const {
  return std::find(own_lines_.begin(), own_lines_.end(), line) != own_lines_.end();
}

void ControlReader::put(std::vector<ControlBlock>& blocks, bool rapid, int pieces, bool goes_on) {
  Block block;
  block.op = rapid ? Op::kRapid : Op::kFeed;
  block.target = at_;
  block.feed = rapid ? 0.0 : feed_ * (slides_ && !inverse_ ? unit_ : 1.0);
  block.inverse_time = !rapid && inverse_;
  if (block.inverse_time) block.feed *= pieces;
  block.goes_on = goes_on;
  block.exact_stop = exact_ && !goes_on;
  block.spindle = spindle_;
  block.line = lines_;
  block.tool = tool_;
  block.off_path = off_path_;
  blocks.push_back({block, tcp_, fresh_});
  fresh_ = false;
}

void ControlReader::put_code(std::vector<ControlBlock>& blocks, int code) {
  Block block;
  block.op = Op::kMCode, block.m_code = code, block.target = at_, block.spindle = spindle_;
  block.line = lines_, block.tool = tool_;
  blocks.push_back({block, tcp_, fresh_});
}

/// Where the axes stand does not change, what X Y Z mean does.
ControlReader::Wrong ControlReader::set_tcp(bool on) {
  if (on == tcp_) return std::nullopt;
  if (on && plane_) return "TCP in a tilted plane is refused";
  if (whole())
    at_ = on ? frames_.tip_words(at_) : frames_.slide_words(at_);
  else
    known_[0] = known_[1] = known_[2] = false, fresh_ = true;
  tcp_ = on;
  return std::nullopt;
}

double ControlReader::turned(const RotaryAxis& axis, double at, WordWay way, double word) const {
  const double circle = 360.0 * std::floor(at / 360.0) + (word - 360.0 * std::floor(word / 360.0));
  switch (way) {
    case WordWay::kShortest:
      return turned_to(RotaryWord::kShortest, word, at);
    case WordWay::kForward:
      return circle < at ? circle + 360.0 : circle;
    case WordWay::kBack:
      return circle > at ? circle - 360.0 : circle;
    case WordWay::kPlain:
      break;
  }
  // These turn the shorter way only where a word says so; without it a place is one of the present turn.
  const bool told = dialect_ == config::Dialect::kSiemens || tnc();
  if (axis.word == RotaryWord::kShortest && told && !shortest_)
    return word >= 0.0 && word < 360.0 ? circle : word;
  return turned_to(axis.word, word, at);
}

/// Whether X Y Z count from the table at home or as it stands where TCP begins, these controls' parameters
/// say: at home both are one.
ControlReader::Wrong ControlReader::table_away() const {
  const auto away = [&](const RotaryAxis& axis, bool known, double at) {
    return axis.present && (!known || std::abs(std::remainder(at - axis.zero, 360.0)) > kAtHome);
  };
  const bool tilts = model_.structure == Structure::kTableTable && away(model_.tilt, known_[3], at_.a);
  const bool turns = model_.structure != Structure::kHeadHead && away(model_.rotary, known_[4], at_.c);
  if (!posted_ || (!tilts && !turns)) return std::nullopt;
  return std::string("TCP begins while ") + (tilts ? model_.tilt.letter : model_.rotary.letter) +
         " of the table is not at home: the control may count X Y Z from where it stands";
}

ControlReader::Wrong ControlReader::other_unit(bool inches) const {
  if (inches == (unit_ != 1.0)) return std::nullopt;
  return inches ? "the program is in inches" : "the program is in mm, and the profile says units: inch";
}

ControlReader::Wrong ControlReader::one_code(int tenths) {
  const bool heidenhain = dialect_ == config::Dialect::kHeidenhainIso;
  if (tenths == 0 || tenths == 10) {
    rapid_ = tenths == 0, motion_known_ = true, arc_ = 0;
  } else if (heidenhain && (tenths == 710 || tenths == 730)) {
    return std::nullopt;  // mm; the rotation is looked at where its angle is
  } else if (heidenhain && tenths == 510) {
    return std::nullopt;  // makes the next tool ready
  } else if (tenths == 434 || tenths == 2340) {
    if (auto turned_away = table_away()) return turned_away;
    return set_tcp(true);
  } else if (tenths == 910) {
    relative_ = true;
  } else if (tenths == 200 || tenths == 700 || tenths == 7000) {
    return other_unit(true);
  } else if (tenths == 210 || tenths == 710 || tenths == 7100) {
    return other_unit(false);
  } else if (tenths == 20 || tenths == 30) {
    rapid_ = false, motion_known_ = true, arc_ = tenths / 10;
  } else if (selects_plane(tenths)) {
    arc_plane_ = tenths / 10;
  } else if (!holds(kQuietG, tenths) && !further_offset(tenths, dialect_) && !of_planes(tenths, dialect_)) {
    return code_text('G', tenths) + " is not understood";
  }
  if (tenths == 900) relative_ = false;
  if (tenths == 490 || tenths == 430) set_tcp(false);
  if (tenths == 610 || tenths == 611 || tenths == 600) exact_ = true;
  if (tenths >= 640 && tenths <= 645) exact_ = false;
  if (tenths == 930 || tenths == 940) {
    if (inverse_ != (tenths == 930)) feed_ = 0.0;
    inverse_ = tenths == 930;
  }
  return std::nullopt;
}

ControlReader::Wrong ControlReader::names(const ControlWords& words) {
  for (std::size_t i = 0; i < words.name_count; ++i) {
    const std::string_view name = words.names[i];
    if (name == "TRAORI" || name == "TRAFOOF")
      if (auto wrong = set_tcp(name == "TRAORI")) return wrong;
    const bool plane = dialect_ == config::Dialect::kSiemens && name.starts_with("CYCLE800(");
    const bool measure =
        plane || name.starts_with("FGROUP(") || name.starts_with("FGREF[") || name.starts_with("CYCLE832(");
    const bool known = dialect_ == config::Dialect::kSiemens
                           ? holds(kSiemensNames, name)
                           : dialect_ == config::Dialect::kHeidenhain && holds(kDialogueNames, name);
    if (!measure && !known) return "\"" + std::string(name) + "\" is not understood";
    // With words behind them they shift or turn the part.
    if ((name == "TRANS" || name == "ROT") && words.seen != 0)
      return std::string(name) + " with axis words is refused";
  }
  return std::nullopt;
}

/// Words that mean something only with a code beside them, by which a control stops or does what nobody
/// reads.
ControlReader::Wrong ControlReader::alone(const ControlWords& words) const {
  using config::Dialect;
  const auto any = [&](std::initializer_list<int> tenths) {
    return std::any_of(tenths.begin(), tenths.end(), [&](int code) { return words.has_g(code); });
  };
  const bool plain = dialect_ == Dialect::kHeidenhain, blends = dialect_ == Dialect::kRs274 && any({640});
  const std::pair<char, bool> meant[]{{'P', blends || any({40, 541, 1540})},
                                      {'Q', blends},
                                      {'R', plain && words['R'] == 0.0},
                                      {'H', any({430, 434, 2340, 730})},
                                      {'D', dialect_ == Dialect::kSiemens}};
  for (const auto& [letter, means] : meant)
    if (words.has(letter) && !means) return std::string(1, letter) + " belongs to no code of this line";
  return std::nullopt;
}

ControlReader::Wrong ControlReader::letters(const ControlWords& words) const {
  constexpr std::string_view kOthers = "XYZFSTHDPRQIJK";
  for (char letter = 'A'; letter <= 'Z'; ++letter) {
    if (!words.has(letter) || kOthers.find(letter) != kOthers.npos || letter == model_.tilt.letter ||
        letter == model_.rotary.letter)
      continue;
    return std::string(1, letter) + " is no word of this machine";
  }
  if (auto wrong = alone(words)) return wrong;
  if (auto wrong = centre_words(words)) return wrong;
  if (words.has_g(730) && !(words.has('H') && words['H'] == 0.0)) return "a turned part is refused";
  return std::nullopt;
}

/// A posted block never turns a rotary by more than half a turn: then a word for the way, a sign or a digit
/// is not what it was.
ControlReader::Wrong ControlReader::half_turn(const Joints& from) const {
  constexpr double kHalf = 180.0 + 1e-9;
  const auto far = [&](const RotaryAxis& axis, double by) { return axis.present && std::abs(by) > kHalf; };
  const bool tilt = far(model_.tilt, at_.a - from.a);
  if (!tilt && !far(model_.rotary, at_.c - from.c)) return std::nullopt;
  return std::string(1, tilt ? model_.tilt.letter : model_.rotary.letter) +
         " turns by more than 180 degrees, which no posted block does: is its way or its sign lost?";
}

/// A Z in machine coordinates goes up to the end of its travel; the other axes go where nobody says.
ControlReader::Wrong ControlReader::to_machine_place(const ControlWords& words,
                                                     std::vector<ControlBlock>& blocks) {
  const bool tcp = tcp_;
  const std::array<char, 5> letter{'X', 'Y', 'Z', model_.tilt.letter, model_.rotary.letter};
  // By way of the place that is stated: absolute, Z0 is in the part.
  const auto stays = [&](char one) { return !words.has(one) || (relative_ && words[one] == 0.0); };
  if (words.has_g(280) && !std::all_of(letter.begin(), letter.end(), stays))
    return "G28 goes by way of a place; only G91 G28 with zeros is understood";
  // A reference point is gone to in rapid always, and by Fanuc's G53, too.
  const bool plain = dialect_ == config::Dialect::kHeidenhain;
  const bool always = words.has_g(280) || (words.has_g(530) && dialect_ == config::Dialect::kFanuc);
  if (!always && !plain && !retract_ && !motion_known_)
    return "a place in machine coordinates before the first G0 or G1: how the axes go there is not known";
  if (posted_ && !always && !retract_ && !(plain ? words.named("FMAX") : rapid_))
    return "a place in machine coordinates that is not gone to in rapid: no posted program does so";
  set_tcp(false);
  for (std::size_t i = 0; i < letter.size(); ++i)
    if (i != 2 && words.has(letter[i])) known_[i] = false, fresh_ = true;
  if (words.has('Z')) {
    at_.z = model_.z.max, known_[2] = off_path_ = true;
    if (plane_) plane_->at.reset();
    if (whole()) put(blocks, true);
  }
  set_tcp(tcp);
  return std::nullopt;
}

ControlReader::Wrong ControlReader::motion(const ControlWords& words, std::vector<ControlBlock>& blocks) {
  const std::array<char, 5> letter{'X', 'Y', 'Z', model_.tilt.letter, model_.rotary.letter};
  if (take_pole(words)) return std::nullopt;
  if (!std::any_of(letter.begin(), letter.end(), [&](char one) { return words.has(one); }))
    return std::nullopt;
  if (words.has_g(530) || words.has_g(280) || words.named("SUPA") || words.has_m(91) ||
      (tnc() && words.has_m(92)))
    return to_machine_place(words, blocks);
  if (relative_) return "incremental words are refused";
  const bool plain = dialect_ == config::Dialect::kHeidenhain;
  const bool arc = plain ? words.named("C") : arc_ != 0;
  if (plain && !arc && !words.named("L")) return "axis words without L";
  if (!plain && !motion_known_) return "axis words before the first G0 or G1";
  const std::array<double*, 5> place{&at_.x, &at_.y, &at_.z, &at_.a, &at_.c};
  const Joints from = at_;
  const bool began = whole();
  const Joints start = arc && began ? arc_words() : from;
  if (plane_)
    if (auto wrong = plane_place(words)) return wrong;
  for (std::size_t i = 0; i < letter.size() && !plane_; ++i) {
    if (!words.has(letter[i])) continue;
    double word = words[letter[i]];
    if (counts_points_ && !words.has_point(letter[i])) word *= 1e-3;
    const WordWay way = words.way[static_cast<std::size_t>(letter[i] - 'A')];
    const RotaryAxis& axis = i == 3 ? model_.tilt : model_.rotary;
    *place[i] = i < 3 ? word * unit_ : turned(axis, known_[i] ? *place[i] : 0.0, way, word);
    known_[i] = true;
  }
  const bool rapid = plain ? words.named("FMAX") : rapid_;
  if (!whole() && !rapid) return "a feed move before all five axis words are stated";
  if (!whole()) return std::nullopt;
  if (!rapid && (!(feed_ > 0.0) || (inverse_ && !words.has('F')))) return "a feed move without F";
  const bool linear = words.has('X') || words.has('Y') || words.has('Z');
  slides_ = linear;
  if (posted_ && began && (linear || !rapid))
    if (auto far = half_turn(from)) return far;
  if (arc && !began) return "an arc from a place that is not known";
  if (arc) return put_arc(words, start, blocks);
  put(blocks, rapid);
  if (words.has('Z')) off_path_ = false;
  return std::nullopt;
}

ControlReader::Wrong ControlReader::read(std::string_view line, std::vector<ControlBlock>& blocks) {
  Wrong wrong;
  if (whole_line(line, wrong, blocks)) return wrong;
  ControlWords words;
  if (auto bad = take_apart(line, words)) return bad;
  if (dialect_ == config::Dialect::kFanuc && words.has_g(682)) {
    ReadPlane plane;
    if (auto bad = read_g68_2(words, plane)) return bad;
    return begin_plane(plane, false);
  }
  for (std::size_t i = 0; i < words.g_count; ++i)
    if (auto bad = one_code(words.g[i])) return bad;
  if (auto bad = names(words)) return bad;
  if (auto bad = planes(words)) return bad;
  if (auto bad = letters(words)) return bad;
  if (words.has_g(40)) return dwell(words, blocks);
  if (words.has_g(2470)) return std::nullopt;
  if (words.has('F')) feed_ = words['F'];
  if (auto bad = machine_codes(words, blocks)) return bad;
  if (auto bad = motion(words, blocks)) return bad;
  if (words.has_g(434) || words.has_g(2340))
    if (auto bad = table_away()) return bad;
  for (std::size_t i = 0; i < words.m_count; ++i)
    if (words.m[i] <= 2 || words.m[i] == 30) put_code(blocks, words.m[i]);
  return std::nullopt;
}

Result<void> ControlReader::read_line(std::string_view line, std::vector<ControlBlock>& blocks) {
  ++lines_;
  if (!posted_ && fresh_) posted_ = line.find("TILTFEED blocks ") != line.npos;
  const std::string_view bare = bare_line(line, dialect_, room_);
  if (bare.empty()) return {};
  retract_ = bare == own_retract_;
  if (!own_line(bare)) {
    if (auto wrong = read(bare, blocks)) return fail(Code::kInput, *wrong);
    return {};
  }
  // Of the profile's own text what is understood counts. That the rest does not move the axes is the
  // profile's to say.
  const ControlReader before = *this;
  const std::size_t count = blocks.size();
  if (!read(bare, blocks)) return {};
  *this = before;
  blocks.resize(count);
  return {};
}

Result<void> read_control_program(std::istream& in, const std::string& name, ControlReader& reader,
                                  const std::function<void(const ControlBlock&)>& take) {
  std::vector<ControlBlock> blocks;
  Lines lines(in);
  while (!reader.ended()) {
    const auto line = lines.next();
    if (!line) break;
    blocks.clear();
    if (auto read = reader.read_line(*line, blocks); !read)
      return fail(read.error().code,
                  name + ":" + std::to_string(reader.lines()) + ": " + read.error().message);
    for (const ControlBlock& block : blocks) take(block);
  }
  if (in.bad()) return fail(Code::kIo, name + ": cannot be read to its end");
  return {};
}

}  // namespace tiltfeed::sim
