// Every kind of bad machine profile, with the exact place and the remedy that its message must have.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <sstream>
#include <string_view>
#include <vector>

#include "config/key_names.h"
#include "tests/texts/machine_text.h"

namespace tiltfeed {
using namespace config;
namespace {

TEST(MachineProfile, ALongLineNeedsABufferOnlyWhereCharactersAreCounted) {
  const std::string no_link =
      replaced(kGoodMachine, "link: {default: \"serial:/dev/ttyACM0\", receive_buffer_bytes: 1024}\n", "");
  const std::string long_line = replaced(no_link, "max_line_length: 70", "max_line_length: 252");
  EXPECT_TRUE(
      parse_machine(replaced(long_line, "dialect: grbl", "dialect: rs274"), kMachinePath).has_value());
  expect_bad(parse_machine(long_line, kMachinePath), kMachinePath,
             {"", "252 bytes", "1:1", "127 bytes do not hold a line"});
  EXPECT_TRUE(
      parse_changed("receive_buffer_bytes: 1024", "receive_buffer_bytes: 71").has_value());  // 70 + line end
}

TEST(MachineProfile, TcpBeginsWithATableThatCanStandAtHome) {
  const std::string away = replaced(kGoodMachine, "min_deg: -360, max_deg: 720", "min_deg: 5, max_deg: 355");
  EXPECT_TRUE(parse_machine(away, kMachinePath));
  const auto posted = [&](const std::string& dialect) {
    return parse_machine(replaced(away, "dialect: grbl", "dialect: " + dialect + "\n  tcp: true"),
                         kMachinePath);
  };
  for (const std::string dialect : {"fanuc", "haas"})
    expect_bad(posted(dialect), kMachinePath,
               {"", "", "21:8", "the travel of C has no place at home for that; post without tcp"});
  EXPECT_TRUE(posted("siemens"));
}

const std::vector<BadText> kBadProfiles = {
    {"", "", "1:1", "empty"},
    {"name: nutator 5", "name: nutator (5)", "1:7", "1 to 40 of the letters"},
    {"name: nutator 5\n", "", "1:1", "missing key 'name'"},
    {"tilt:", "head:", "6:1", "unknown key 'head'"},
    {"linear:", "linears:", "2:1", "nearest known key: linear"},
    {"  z: {", "  w: {", "5:3", "unknown key 'w' in linear"},
    {"  y: {", "  x: {", "4:3", "duplicate key 'x', first given on line 3"},
    {"min_mm: -5, ", "", "4:6", "missing key 'linear.y.min_mm'"},
    {"min_mm: -1", "min_mm: 2", "3:26", "2 mm is not above min_mm, 2 mm"},
    {"max_mm: 10", "max_mm: -9.5", "5:27", "-9.5 mm is not above min_mm, -9 mm"},
    {"velocity_mm_per_min: 3", "velocity_mm_per_s: 3", "3:30", "nearest known key: velocity_mm_per_min"},
    {"velocity_mm_per_min: 3", "velocity_mm_per_min: 0", "3:51", "above 0"},
    {"acceleration_mm_per_s2: 8", "acceleration_mm_per_s2: -8", "4:78", "number of mm/s^2 above 0"},
    {"letter: B", "letter: X", "7:11", "one of the letters A B C E U V W, found 'X'"},
    {"letter: B", "letter: Y", "7:11", "A B C E U V W"},
    {"letter: B", "letter: Z", "7:11", "A B C E U V W"},
    {"letter: B", "letter: F", "7:11", "A B C E U V W"},
    {"letter: B", "letter: G", "7:11", "A B C E U V W"},
    {"letter: B", "letter: M", "7:11", "A B C E U V W"},
    {"letter: B", "letter: N", "7:11", "A B C E U V W"},
    {"letter: B", "letter: S", "7:11", "A B C E U V W"},
    {"letter: B", "letter: T", "7:11", "A B C E U V W"},
    {"letter: B", "letter: b", "7:11", "A B C E U V W"},
    {"letter: B", "letter: AB", "7:11", "A B C E U V W"},
    {"letter: B", "letter: \"\"", "7:11", "expected a text"},
    {"letter: B", "letter: C", "15:18", "C is tilt.letter too"},
    {"direction: [0, 3, 4]", "direction: [0, 0, -1]", "8:14", "it is that of the spindle"},
    {"direction: [0, 3, 4]", "direction: [0, 0.01, 1]", "8:14", "at least 1 degree"},
    {"direction: [0, 3, 4]", "direction: [0, 0, 0]", "8:14", "zero vector"},
    {"direction: [0, 0, 2]", "direction: [0, 3, 4.001]", "15:32", "two axes at least 1 degree apart"},
    {"rotary: {", "rotary: {prefer: positive, ", "15:10", "unknown key 'prefer'"},
    {"rotary: {", "rotary: {word: modulo, ", "15:16", "expected one of accumulate, shortest, signed"},
    {"rotary: {", "rotary: {word: signed, ", "15:76", "not used by an axis that turns without end"},
    {"rotary: {", "rotary: {continuous: true, ", "15:80", "not used by an axis that turns without end"},
    {"rotary: {letter: C, direction: [0, 0, 2], sign: +1, min_deg: -360, max_deg: 720,",
     "rotary: {letter: C, direction: [0, 0, 2], sign: +1, word: shortest, continuous: false,", "15:81",
     "modulo 360 has no limits"},
    {"letter: B", "prefer: left\n  letter: B", "7:11", "expected one of positive, negative, quicker"},
    {"tilt:", "structure: head-table\ntilt:", "6:12", "expected one of table-head, table-table, head-head"},
    {"tilt:", "structure: table-table\nrotary_to_tilt_mm: [0, 0, 0]\ntilt:", "20:20",
     "not used without a tilting head"},
    {"tilt:", "structure: head-head\ntilt:", "1:1", "missing key 'rotary_to_tilt_mm'"},
    {"tilt:", "rotary_to_tilt_mm: [0, 0, 0]\ntilt:", "6:20", "where the slides lie between"},
    {"tilt:", "spindle_direction: [0, 3, 4]\ntilt:", "9:14", "it is that of the spindle"},
    {"sign: -1", "sign: 0", "9:9", "expected one of 1, +1, -1, found '0'"},
    {"sign: -1", "sign: -1.0", "9:9", "expected one of 1, +1, -1"},
    {"sign: -1", "sign: minus", "9:9", "expected one of 1, +1, -1"},
    {"zero_deg: 1.5", "zero_rad: 1.5", "10:3", "nearest known key: zero_deg (unit: degrees)"},
    {"min_deg: -30", "min_deg: 95", "12:12", "95 degrees is not above min_deg, 95 degrees"},
    {"min_deg: -30", "min_deg: -361", "11:12", "at least -360"},
    {"max_deg: 720", "max_deg: -361", "15:77", "not above min_deg"},
    {"velocity_deg_per_min: 13", "velocity_deg_per_min: .inf", "13:25", "it must be finite"},
    {"[1.5, -22, -145.4]", "[1.5, -22, 0.5]", "18:20", "expected at most 0"},
    {"[1.5, -22, -145.4]", "[1.5, -22]", "18:20", "[x, y, z]"},
    {"pivot_to_gauge_mm: [1.5, -22, -145.4]\n", "", "1:1", "missing key 'pivot_to_gauge_mm'"},
    {"dialect: grbl", "dialect: okuma", "20:12", "expected one of rs274, grbl, fanuc, haas, siemens"},
    {"dialect: grbl", "dialect: heidenhain\n  feed_mode: inverse_time", "21:14", "has no inverse time"},
    {"dialect: grbl", "dialect: grbl\n  tcp: true", "21:8", "grbl has no words for TCP"},
    {"dialect: grbl", "dialect: grbl\n  tilted_planes: true", "21:18",
     "grbl has no words for a tilted plane"},
    {"dialect: grbl", "dialect: haas\n  tilted_planes: true", "21:18", "the head of this machine turns"},
    {"dialect: grbl", "dialect: fanuc\n  tilted_planes: true\n  retract: none", "21:18", "retract is none"},
    {"dialect: grbl", "dialect: grbl\n  swivel_data: TABLE", "21:16", "unless the dialect is siemens"},
    {"dialect: grbl", "dialect: siemens\n  swivel_data: \"0\"", "21:16", "ends the swivel data"},
    {"dialect: grbl", "dialect: siemens\n  swivel_data: table", "21:16", "A-Z 0-9 _ - ."},
    {"dialect: grbl", "dialect: siemens\n  swivel_data: \"T,1\"", "21:16", "A-Z 0-9 _ - ."},
    {"dialect: grbl", "dialect: siemens\n  swivel_data: A23456789012345678901234567890123", "21:16",
     "at most 32"},
    {"dialect: grbl", "dialect: grbl\n  units: inch", "21:10", "sent, followed and resumed in mm"},
    {"dialect: grbl", "dialect: heidenhain\n  units: inch", "21:10", "state feed_measure: xyz"},
    {"dialect: grbl", "dialect: siemens\n  units: inch\n  feed_mode: per_minute\n  feed_measure: degrees",
     "23:17", "state feed_measure: xyz"},
    {"dialect: grbl", "dialect: fanuc\n  preselect_tools: maybe", "21:20", "one of true, false"},
    {"dialect: grbl", "dialect: grbl\n  preselect_tools: true", "21:20", "grbl changes no tools"},
    {"dialect: grbl", "dialect: fanuc\n  through_coolant_on: M88", "21:23", "belong together"},
    {"dialect: grbl", "dialect: fanuc\n  through_coolant_on: M88\n  through_coolant_off: M88", "22:24",
     "the same"},
    {"dialect: grbl", "dialect: fanuc\n  through_coolant_on: M198 P1\n  through_coolant_off: M89", "21:23",
     "\"M198\""},
    {"dialect: grbl", "dialect: fanuc\n  through_coolant_on: M6\n  through_coolant_off: M89", "21:23",
     "\"M6\""},
    {"dialect: grbl", "dialect: fanuc\n  through_coolant_on: M88\n  through_coolant_off: G0 Z-9.", "22:24",
     "\"G0\""},
    {"dialect: grbl", "dialect: grbl\n  line_end: crlf", "21:13", "two ok"},
    {"dialect: grbl", "dialect: grbl\n  path_control: exact", "21:17", "words of rs274"},
    {"dialect: grbl", "dialect: rs274\n  path_control: blend", "20:3",
     "missing key 'program.blend_tolerance_mm'"},
    {"dialect: grbl", "dialect: rs274\n  blend_tolerance_mm: 1", "21:23",
     "not used unless path_control is blend"},
    {"dialect: grbl", "dialect: fanuc\n  tcp: true\n  feed_mode: per_minute", "22:14", "not used under TCP"},
    {"dialect: grbl", "dialect: fanuc\n  tcp_start_below_mm: 9", "21:23", "not used unless tcp is true"},
    {"dialect: grbl", "dialect: fanuc\n  tcp: true\n  tcp_start_below_mm: -1", "22:23", "tcp_start_below_mm"},
    {"dialect: grbl", "dialect: fanuc\n  feed_radius_mm: 5", "21:19",
     "not used unless feed_measure is radius"},
    {"dialect: grbl", "dialect: fanuc\n  clamp_tilt: M10", "21:15", "belong together"},
    {"dialect: grbl", "dialect: fanuc\n  retract: \"G0 (up)\"", "21:12", "expected words of a program"},
    {"dialect: grbl", "dialect: fanuc\n  start: G0 (up)", "21:10", "expected words of a program"},
    {"dialect: grbl", "dialect: fanuc\n  start: [M10, G0 Z100]", "21:10", "\"G0 Z100\" moves an axis"},
    {"dialect: grbl", "dialect: fanuc\n  end: G91 B0", "21:8", "moves an axis"},
    {"dialect: grbl", "dialect: fanuc\n  start: G91 G28 Z0", "21:10",
     "leaves incremental words (G91) in force"},
    {"dialect: grbl", "dialect: fanuc\n  start: [M10, G91]", "21:10", "\"G91\" leaves incremental words"},
    {"dialect: grbl", "dialect: fanuc\n  start: G28 Z0", "21:10",
     "by way of a place in the part's coordinates"},
    {"dialect: grbl", "dialect: fanuc\n  end: [G91 G28 Z0, G90, G0G28X0]", "21:8", "\"G0G28X0\" goes by way"},
    {"dialect: grbl", "dialect: fanuc\n  retract: G91 G28 Z0", "21:12", "leaves incremental words"},
    {"dialect: grbl", "dialect: fanuc\n  retract: G0 Z100", "21:12", "is no way in machine coordinates"},
    {"dialect: grbl", "dialect: fanuc\n  retract: M98 P9000", "21:12", "expected Z alone with G53"},
    {"dialect: grbl", "dialect: haas\n  retract: G53 X0 Y0", "21:12", "does not move Z"},
    {"dialect: grbl", "dialect: siemens\n  retract: G0 SUPA X0 Z0 D0", "21:12", "moves more than Z"},
    {"dialect: grbl", "dialect: heidenhain\n  retract: L Z+100 R0 FMAX", "21:12",
     "expected Z alone with M91 or M92"},
    {"dialect: grbl", "dialect: fanuc\n  end: [G91 G28 X0 Y0, M9]", "21:8",
     "\"G91 G28 X0 Y0\" leaves incremental words"},
    {"dialect: grbl", "dialect: fanuc\n  start: G20", "21:10", "selects inches"},
    {"dialect: grbl", "dialect: siemens\n  start: G700", "21:10", "selects inches"},
    {"dialect: grbl", "dialect: fanuc\n  start: M30", "21:10", "ends the program"},
    {"dialect: grbl", "dialect: siemens\n  start: TRAORI", "21:10", "tool centre point"},
    {"dialect: grbl", "dialect: heidenhain\n  start: M128", "21:10", "tool centre point"},
    {"dialect: grbl", "dialect: fanuc\n  start: G68.2 P1", "21:10", "tilted plane"},
    {"dialect: grbl", "dialect: siemens\n  start: \"CYCLE832(0.01,1\"", "21:10",
     "expected words of a program"},
    {"dialect: grbl", "dialect: fanuc\n  start: [M10, [G4]]", "21:16", "expected one line of text"},
    {"dialect: grbl", "dialect: fanuc\n  end: g53", "21:8", "expected words of a program"},
    {"dialect: grbl", "dialect: siemens\n  percent: true", "21:12", "do not stand between two %"},
    {"dialect: grbl", "dialect: fanuc\n  max_blocks: -1", "21:15", "whole number"},
    {"linear_decimals: 3", "linear_decimals: 0", "21:20", "a whole number from 1 to 6"},
    {"linear_decimals: 3", "linear_decimals: 7", "21:20", "a whole number from 1 to 6"},
    {"linear_decimals: 3", "linear_decimals: 3.0", "21:20",
     "expected a whole number, found '3.0'; write digits only"},
    {"linear_decimals: 3", "linear_decimals: 03", "21:20", "without the leading zero"},
    {"linear_decimals: 3", "linear_decimals: \"3\"", "21:20", "remove the quotes"},
    {"linear_decimals: 3", "linear_decimals: three", "21:20", "expected a whole number, found 'three'"},
    {"linear_decimals: 3", "linear_decimals: [3]", "21:20", "found a list of 1"},
    {"linear_decimals: 3", "linear_decimals: 99999999999999999999", "21:20", "out of range"},
    {"rotary_decimals: 5", "rotary_decimals:", "22:3", "found nothing"},
    {"max_line_length: 70", "max_line_length: 15", "23:20", "from 16 to 4096"},
    {"line_numbers: true", "line_numbers: yes", "24:17", "expected one of true, false, found 'yes'"},
    {"max_inverse_time_per_min: 9999.5", "max_inverse_time_per_min: 0", "25:29", "above 0"},
    {"receive_buffer_bytes: 1024", "receive_buffer_bytes: 70", "26:62", "lower max_line_length"},
    {"receive_buffer_bytes: 1024", "receive_buffer_bytes: 65537", "26:62",
     "number of bytes from 17 to 65536"},
    {"receive_buffer_bytes: 1024", "bytes_per_s: -1, receive_buffer_bytes: 1024", "26:53",
     "expected a number at least 0"},
    {"receive_buffer_bytes: 1024", "receive_buffer: 1024", "26:40",
     "nearest known key: receive_buffer_bytes"},
    {"jerk_mm_per_s3: 23", "jerk_mm_per_s3: 0", "3:97", "number of mm/s^3 above 0"},
    {"jerk_deg_per_s3: 24", "jerk_deg_per_s2: 24", "16:65", "nearest known key: jerk_deg_per_s3"},
    {"tilt:", "check: [{x_mm: 1, y_mm: 2, z_mm: 3, tilt_deg: 1.5, rotary_deg: 0, tip_mm: [1, 2, 4]}]\ntilt:",
     "6:75", "the profile puts the tool at (1, 2, 3)"},
    {"tilt:", "check: [{x_mm: 1, y_mm: 2, z_mm: 3, tilt_deg: 1.5, rotary_deg: 0, tip: [1, 2, 4]}]\ntilt:",
     "6:67", "nearest known key: tip_mm"},
    {"look_ahead_blocks: 40", "look_ahead_blocks: 0", "27:30", "number of blocks from 1 to 100000"},
    {"corner_time_ms: 2.5", "corner_time_ms: -1", "27:50", "at least 0"},
    {"corner_time_ms: 2.5", "corner_time_s: 2.5", "27:34", "nearest known key: corner_time_ms (unit: ms)"},
    {"blend_rotary: false", "blend_rotary: 0", "27:69", "expected one of true, false"},
};

TEST(MachineProfile, EveryKindOfBadInputHasItsPlace) {
  for (const BadText& bad : kBadProfiles) expect_bad(parse_changed(bad.from, bad.to), kMachinePath, bad);
}

TEST(MachineProfile, AWrongSignIsNamedByThePlaceThatDisagrees) {
  // Places by (K1), written out for this machine: B about (0, 0.6, 0.8), C about z, both as in kGoodMachine.
  const Result<MachineProfile> profile = parse_machine(kGoodMachine, kMachinePath);
  ASSERT_TRUE(profile.has_value());
  for (const auto& [tilt, rotary] : {std::pair{31.5, 0.0}, {1.5, 40.0}, {21.5, -70.0}}) {
    const auto turned = [](Vec3 v, Vec3 n, double degrees) {
      return rotation_about(n, degrees * kPi / 180) * v;
    };
    const Vec3 lever{1.5, -22, -245.4}, bent = turned(lever, {0, 0.6, 0.8}, -(tilt - 1.5));
    const Vec3 tip = turned(Vec3{10, 20, 30} + bent - lever, {0, 0, 1}, -rotary);
    const Vec3 axis = turned(turned({0, 0, 1}, {0, 0.6, 0.8}, -(tilt - 1.5)), {0, 0, 1}, -rotary);
    std::ostringstream vector;
    vector.precision(12);
    vector << "check:\n  - {x_mm: 10, y_mm: 20, z_mm: 30, tilt_deg: " << tilt << ", rotary_deg: " << rotary
           << ", tool_length_mm: 100,\n     tip_mm: [" << tip.x << ", " << tip.y << ", " << tip.z
           << "], axis: [" << axis.x << ", " << axis.y << ", " << axis.z << "]}\n";
    const std::string text = vector.str() + kGoodMachine;
    ASSERT_TRUE(parse_machine(text, kMachinePath).has_value())
        << parse_machine(text, kMachinePath).error().message;
    const auto wrong_tilt = parse_machine(replaced(text, "sign: -1", "sign: 1"), kMachinePath);
    const auto wrong_rotary = parse_machine(replaced(text, "sign: +1", "sign: -1"), kMachinePath);
    ASSERT_EQ(wrong_tilt.has_value(), tilt == 1.5);
    ASSERT_EQ(wrong_rotary.has_value(), rotary == 0.0);
    const auto expect_said = [](const auto& result, const char* part) {
      EXPECT_NE(result.error().message.find(part), std::string::npos) << result.error().message;
    };
    if (!wrong_tilt) {
      expect_said(wrong_tilt, "check[1].tip_mm: the profile puts the tool at");
      expect_said(wrong_tilt, "agree with tilt.sign: -1");
    }
    if (!wrong_rotary) {
      expect_said(wrong_rotary, "agree with rotary.sign: 1");
    }
    const auto longer =
        parse_machine(replaced(text, "tool_length_mm: 100", "tool_length_mm: 130"), kMachinePath);
    if (tilt != 1.5) {
      ASSERT_FALSE(longer.has_value());
      EXPECT_NE(longer.error().message.find("no sign makes it agree"), std::string::npos);
    }
  }
}

TEST(KeyNames, TheNearestKeyIsTheSameWordsElseTheLeastEdits) {
  const std::vector<std::string> known = {"mode", "side_step_mm", "min_deg", "max_deg", "cut_mm_per_min"};
  EXPECT_EQ(nearest_key("side_step", known), "side_step_mm");
  EXPECT_EQ(nearest_key("cut", known), "cut_mm_per_min");  // mode is nearer by letters
  EXPECT_EQ(nearest_key("side_step_inch", known), "side_step_mm");
  EXPECT_EQ(nearest_key("cut_mm_per_s", known), "cut_mm_per_min");
  EXPECT_EQ(nearest_key("max_degrees", known), "max_deg");
  EXPECT_EQ(nearest_key("maxdeg", known), "max_deg");
  EXPECT_EQ(nearest_key("mde", known), "mode");
  EXPECT_EQ(nearest_key("mi_deg", known), "min_deg");
  EXPECT_EQ(nearest_key("m_deg", known), "mode");  // two edits from min_deg too: the first of equals
  EXPECT_EQ(unit_of("cut_mm_per_min"), "mm/min");
  EXPECT_EQ(unit_of("acceleration_deg_per_s2"), "degrees/s^2");
  EXPECT_EQ(unit_of("max_inverse_time_per_min"), "1/min");
  EXPECT_EQ(unit_of("mode"), "");
}

/// Levenshtein by its definition: the last letters are one, or one of them is added, lost or replaced.
std::size_t edits(std::string_view from, std::string_view to) {
  if (from.empty() || to.empty()) return from.size() + to.size();
  const std::string_view shorter_from = from.substr(1), shorter_to = to.substr(1);
  if (from[0] == to[0]) return edits(shorter_from, shorter_to);
  return 1 + std::min({edits(shorter_from, to), edits(from, shorter_to), edits(shorter_from, shorter_to)});
}

TEST(KeyNames, TheNearestKeyIsTheFirstOfThoseWithTheLeastEdits) {
  std::mt19937 random(1);
  const auto word = [&] {
    std::string letters(random() % 7, 'a');
    for (char& letter : letters) letter = static_cast<char>('a' + random() % 3);
    return letters;
  };
  for (int round = 0; round < 300; ++round) {
    std::vector<std::string> known(8);
    std::generate(known.begin(), known.end(), word);
    const std::string key = word();
    EXPECT_EQ(&nearest_key(key, known),
              &*std::min_element(known.begin(), known.end(),
                                 [&](const auto& a, const auto& b) { return edits(key, a) < edits(key, b); }))
        << key;
  }
}

}  // namespace
}  // namespace tiltfeed
