// Machine profiles: values, structures, defaults, and how they are described.

#include "config/machine_profile.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/texts/machine_text.h"

namespace tiltfeed {
using namespace config;
namespace {

void expect_linear(const LinearAxis& axis, LinearAxis expected) {
  EXPECT_EQ(axis.min, expected.min);
  EXPECT_EQ(axis.max, expected.max);
  EXPECT_EQ(axis.velocity, expected.velocity);
  EXPECT_EQ(axis.acceleration, expected.acceleration);
  EXPECT_EQ(axis.jerk, expected.jerk);
}

TEST(MachineProfile, ReadsEveryValue) {
  const Result<MachineProfile> profile = parse_machine(kGoodMachine, kMachinePath);
  ASSERT_TRUE(profile.has_value()) << profile.error().message;
  EXPECT_EQ(profile->path, kMachinePath);
  const MachineModel& model = profile->model;
  EXPECT_EQ(model.name, "nutator 5");
  expect_linear(model.x, {-1, 2, 3, 4, 23});
  expect_linear(model.y, {-5, 6, 7, 8});
  expect_linear(model.z, {-9, 10, 11, 12});
  EXPECT_EQ(model.tilt.letter, 'B');
  EXPECT_NEAR(length(model.tilt.direction - Vec3{0, 0.6, 0.8}), 0.0, 1e-15);
  EXPECT_EQ(model.tilt.sign, -1);
  EXPECT_EQ(model.tilt.zero, 1.5);
  EXPECT_EQ(model.tilt.min, -30.0);
  EXPECT_EQ(model.tilt.max, 95.0);
  EXPECT_EQ(model.tilt.velocity, 13.0);
  EXPECT_EQ(model.tilt.acceleration, 14.0);
  EXPECT_EQ(model.tilt.jerk, 0.0) << "not limited";
  EXPECT_EQ(model.rotary.letter, 'C');
  EXPECT_EQ(model.rotary.direction, (Vec3{0, 0, 1}));
  EXPECT_EQ(model.rotary.sign, +1);
  EXPECT_EQ(model.rotary.zero, 0.0);
  EXPECT_EQ(model.rotary.min, -360.0);
  EXPECT_EQ(model.rotary.max, 720.0);
  EXPECT_EQ(model.rotary.velocity, 15.0);
  EXPECT_EQ(model.rotary.acceleration, 16.0);
  EXPECT_EQ(model.rotary.jerk, 24.0);
  EXPECT_EQ(model.table_centre, (Point<MachineSpace>{17, 18, 19}));
  EXPECT_EQ(model.pivot_to_gauge, (Vec3{1.5, -22, -145.4}));
  EXPECT_EQ(profile->format.dialect, Dialect::kGrbl);
  EXPECT_EQ(profile->format.linear_decimals, 3);
  EXPECT_EQ(profile->format.rotary_decimals, 5);
  EXPECT_EQ(profile->format.max_line_length, 70);
  EXPECT_TRUE(profile->format.line_numbers);
  EXPECT_EQ(profile->format.max_inverse_time, 9999.5);
  EXPECT_EQ(profile->link, "serial:/dev/ttyACM0");
  EXPECT_EQ(profile->receive_buffer, 1024);
  EXPECT_EQ(profile->control.look_ahead, 40);
  EXPECT_EQ(profile->control.corner_time, 0.0025);
  EXPECT_FALSE(profile->model.blends_rotary);
}

TEST(MachineProfile, ReadsEveryStructure) {
  const std::string table =
      replaced(replaced(kGoodMachine, "tilt:\n",
                        "structure: table-table\nrotary_to_tilt_mm: [1, 2, 3]\n"
                        "spindle_direction: [0, -0.3, 0.4]\ntilt:\n  prefer: negative\n"),
               "pivot_to_gauge_mm: [1.5, -22, -145.4]\n", "");
  const Result<MachineProfile> two = parse_machine(table, kMachinePath);
  ASSERT_TRUE(two.has_value()) << two.error().message;
  EXPECT_EQ(two->model.structure, Structure::kTableTable);
  EXPECT_EQ(two->model.rotary_to_tilt, (Vec3{1, 2, 3}));
  EXPECT_NEAR(length(two->model.spindle - Vec3{0, -0.6, 0.8}), 0.0, 1e-15);
  EXPECT_EQ(two->model.preferred_tilt, -1);
  EXPECT_NE(describe(*two).find("rotary_to_tilt_mm: [1, 2, 3]"), std::string::npos);
  const Result<MachineProfile> head =
      parse_changed("tilt:\n", "structure: head-head\nrotary_to_tilt_mm: [1, 2, 3]\ntilt:\n");
  ASSERT_TRUE(head.has_value()) << head.error().message;
  EXPECT_EQ(head->model.structure, Structure::kHeadHead);
  const Result<MachineProfile> tilted = parse_changed("direction: [0, 0, 2]", "direction: [0, 1e-4, -1]");
  ASSERT_TRUE(tilted.has_value()) << tilted.error().message;
  EXPECT_NEAR(tilted->model.rotary.direction.y, 1e-4, 1e-11);
}

TEST(MachineProfile, AnEndlessAxisHasNoLimits) {
  const struct {
    const char* key;
    RotaryWord word;
  } cases[] = {{"continuous: true", RotaryWord::kAccumulate},
               {"word: shortest", RotaryWord::kShortest},
               {"word: signed", RotaryWord::kSigned},
               {"word: signed, continuous: true", RotaryWord::kSigned}};
  for (const auto& c : cases) {
    const Result<MachineProfile> profile =
        parse_machine(replaced(replaced(kGoodMachine, "min_deg: -360, max_deg: 720", c.key), "dialect: grbl",
                               "dialect: fanuc"),
                      kMachinePath);
    ASSERT_TRUE(profile.has_value()) << profile.error().message;
    EXPECT_EQ(profile->model.rotary.word, c.word);
    EXPECT_EQ(profile->model.rotary.max, std::numeric_limits<double>::infinity());
    EXPECT_NE(describe(*profile).find("rotary.min_deg: none"), std::string::npos);
  }
}

TEST(MachineProfile, StartAndEndTakeSeveralLinesAndParentheses) {
  const Result<MachineProfile> profile =
      parse_changed("dialect: grbl",
                    "dialect: siemens\n  start: [\"CYCLE832(0.01,1)\", G53 G0 Z0]\n  end: G0 SUPA X0 Y0 D0");
  ASSERT_TRUE(profile.has_value()) << profile.error().message;
  EXPECT_EQ(profile->format.start, (std::vector<std::string>{"CYCLE832(0.01,1)", "G53 G0 Z0"}));
  EXPECT_EQ(profile->format.end, (std::vector<std::string>{"G0 SUPA X0 Y0 D0"}));
  EXPECT_NE(describe(*profile).find("program.start: CYCLE832(0.01,1) | G53 G0 Z0\n"), std::string::npos);
  for (const char* fine :
       {"[G91 G28 Z0, G90]", "[G91 G28 Z0 M5, \"G90 (MSG G20)\"]", "G28", "[G5.1 Q1, G54, M7]"}) {
    const auto started = parse_changed("dialect: grbl", std::string("dialect: fanuc\n  start: ") + fine +
                                                            "\n  end: [G91 G28 X0 Y0, G90, M9]");
    EXPECT_TRUE(started) << fine << ": " << started.error().message;
  }
}

TEST(MachineProfile, StartTakesWhatLeavesTheProgramAsItIsMeant) {
  const std::pair<const char*, std::vector<const char*>> fine[]{
      {"rs274", {"G64 P0.02", "G61", "G59.3", "M7", "G4 P1", "G53 G0 Z0", "G80 G40 G49 G69"}},
      {"fanuc", {"G5.1 Q1", "G5 P10000", "G54.1 P5", "G8 P1", "M88", "G28 (G16)", "N10 T5"}},
      {"haas", {"G187 P3 E0.02", "G154 P2", "G103 P1", "G255", "M31"}},
      {"siemens",
       {"CYCLE832(0.01,1)", "G642", "COMPCAD", "FFWON SOFT", "G505", "TRAFOOF", "MSG(\\\"A\\\")",
        "G0 SUPA Z0 D0"}},
      {"heidenhain",
       {"CYCL DEF 32.0 TOLERANCE", "CYCL DEF 32.1 T0.02", "PLANE RESET STAY", "M8", "L Z-1 R0 FMAX M91"}},
      {"heidenhain_iso", {"G62 T0.02", "M8"}}};
  const std::pair<const char*, std::vector<const char*>> wrong[]{
      {"rs274",
       {"T9 M6", "G43 H9", "G38.2 F100", "G10 L2 P1", "G96 S100", "S100 M4", "G18", "G92.1", "O100 CALL"}},
      {"fanuc",
       {"G16", "G68 R45", "G95", "G93", "G51 P2000", "M98 P100", "G65 P9000", "G41 D1", "G12.1",
        "G81 R2 F100"}},
      {"haas", {"G268", "G51.1", "H3", "M97 P3"}},
      {"siemens",
       {"CYCLE81(10,0,1,-5)", "CYCLE800(0,1)", "MCALL CYCLE81(1)", "G0 AP=90 RP=10", "ROT RPL=45", "TOFRAME",
        "TRANSMIT", "GOTOF ENDE", "L100", "MYSUB", "M17", "D2", "DIAMON", "G500", "G95"}},
      {"heidenhain",
       {"LP PR+10 PA+0 FMAX", "CYCL CALL", "CYCL DEF 8.0 MIRROR", "CYCL DEF 10.1 ROT+45", "CALL LBL 1",
        "TOOL CALL 9 Z", "TCH PROBE 0.0 REF PLANE", "M126", "M136"}}};
  const auto with = [](const char* dialect, const std::string& line) {
    return parse_changed("dialect: grbl",
                         std::string("dialect: ") + dialect + "\n  start: [\"" + line + "\"]");
  };
  for (const auto& [dialect, lines] : fine)
    for (const char* line : lines) {
      const auto read = with(dialect, line);
      EXPECT_TRUE(read) << dialect << " " << line << ": " << read.error().message;
    }
  for (const auto& [dialect, lines] : wrong)
    for (const char* line : lines) EXPECT_FALSE(with(dialect, line)) << dialect << " " << line;
}

/// Rounding by half a last decimal in each word stays below a tenth of the tolerances, as far as the control
/// reads decimals; stated ones stay.
TEST(MachineProfile, DecimalsAreFineEnoughForTheTolerance) {
  const struct {
    Dialect dialect;
    double tolerance, axis_tolerance;
    int linear, rotary;
  } table[]{{Dialect::kRs274, 0.0035, 0.005, 4, 4},     {Dialect::kRs274, 0.0007, 0.0005, 5, 5},
            {Dialect::kSiemens, 0.0007, 0.00005, 5, 6}, {Dialect::kGrbl, 0.0007, 0.00005, 4, 4},
            {Dialect::kFanuc, 0.0007, 0.00005, 3, 3},   {Dialect::kRs274, 1e-9, 1e-9, 6, 6}};
  for (const auto& row : table) {
    const ProgramFormat format = fine_enough(usual_format(row.dialect), row.tolerance, row.axis_tolerance);
    EXPECT_EQ(format.linear_decimals, row.linear) << name_of(row.dialect).name;
    EXPECT_EQ(format.rotary_decimals, row.rotary) << name_of(row.dialect).name;
  }
  const Result<MachineProfile> stated = parse_changed("dialect: grbl", "dialect: rs274");  // 3 and 5
  ASSERT_TRUE(stated.has_value()) << stated.error().message;
  EXPECT_EQ(fine_enough(stated->format, 1e-9, 1e-9).linear_decimals, 3);
  EXPECT_EQ(fine_enough(stated->format, 1e-9, 1e-9).rotary_decimals, 5);
}

TEST(MachineProfile, ProgramAndLinkMayBeLeftOut) {
  const std::string least =
      replaced(kGoodMachine.substr(0, kGoodMachine.find("program:")), "table_centre_mm: [17, 18, 19]\n", "");
  const Result<MachineProfile> profile = parse_machine(least, kMachinePath);
  ASSERT_TRUE(profile.has_value()) << profile.error().message;
  EXPECT_EQ(profile->model.table_centre, (Point<MachineSpace>{0, 0, 0}));
  EXPECT_EQ(profile->format.dialect, Dialect::kRs274);
  EXPECT_EQ(profile->format.linear_decimals, 4);
  EXPECT_EQ(profile->format.rotary_decimals, 4);
  EXPECT_EQ(profile->format.max_line_length, 79);
  EXPECT_FALSE(profile->format.line_numbers);
  EXPECT_EQ(profile->format.max_inverse_time, 100000.0);
  EXPECT_EQ(profile->link, "");
  EXPECT_EQ(profile->receive_buffer, 127);
  EXPECT_EQ(profile->control.look_ahead, 200);
  EXPECT_EQ(profile->control.corner_time, 0.005);
  EXPECT_TRUE(profile->model.blends_rotary);
}

TEST(MachineProfile, NamesTheSwivelData) {
  for (const char* name : {"T", "HEAD_2.B-1", "A2345678901234567890123456789012"}) {
    const auto profile =
        parse_changed("dialect: grbl", "dialect: siemens\n  swivel_data: " + std::string(name));
    ASSERT_TRUE(profile.has_value()) << profile.error().message;
    EXPECT_EQ(profile->format.swivel_data, name);
    EXPECT_NE(describe(*profile).find(std::string("program.swivel_data: ") + name + "\n"), std::string::npos);
  }
  const auto without = parse_changed("dialect: grbl", "dialect: siemens");
  ASSERT_TRUE(without.has_value()) << without.error().message;
  EXPECT_NE(describe(*without).find("program.swivel_data: none\n"), std::string::npos);
}

TEST(MachineProfile, DescribesEveryValue) {
  const Result<MachineProfile> profile = parse_machine(kGoodMachine, kMachinePath);
  ASSERT_TRUE(profile.has_value());
  EXPECT_EQ(
      describe(*profile),
      "file: shop/m.yaml\n"
      "name: nutator 5\n"
      "linear.x.min_mm: -1\nlinear.x.max_mm: 2\n"
      "linear.x.velocity_mm_per_min: 3\nlinear.x.acceleration_mm_per_s2: 4\n"
      "linear.x.jerk_mm_per_s3: 23\n"
      "linear.y.min_mm: -5\nlinear.y.max_mm: 6\n"
      "linear.y.velocity_mm_per_min: 7\nlinear.y.acceleration_mm_per_s2: 8\n"
      "linear.z.min_mm: -9\nlinear.z.max_mm: 10\n"
      "linear.z.velocity_mm_per_min: 11\nlinear.z.acceleration_mm_per_s2: 12\n"
      "structure: table-head\n"
      "tilt.letter: B\ntilt.direction: [0, 0.6, 0.8]\ntilt.sign: -1\ntilt.zero_deg: 1.5\n"
      "tilt.word: accumulate\ntilt.min_deg: -30\ntilt.max_deg: 95\n"
      "tilt.velocity_deg_per_min: 13\ntilt.acceleration_deg_per_s2: 14\ntilt.prefer: quicker\n"
      "rotary.letter: C\nrotary.direction: [0, 0, 1]\nrotary.sign: 1\nrotary.zero_deg: 0\n"
      "rotary.word: accumulate\nrotary.min_deg: -360\nrotary.max_deg: 720\n"
      "rotary.velocity_deg_per_min: 15\nrotary.acceleration_deg_per_s2: 16\n"
      "rotary.jerk_deg_per_s3: 24\n"
      "table_centre_mm: [17, 18, 19]\n"
      "pivot_to_gauge_mm: [1.5, -22, -145.4]\n"
      "spindle_direction: [0, 0, 1]\n"
      "check: 0 measured places agree\n"
      "bodies: none: the machine itself is not checked for collisions\n"
      "control.look_ahead_blocks: 40\ncontrol.corner_time_ms: 2.5\ncontrol.blend_rotary: false\n"
      "program.dialect: grbl\nprogram.units: mm\nprogram.linear_decimals: 3\nprogram.rotary_decimals: 5\n"
      "program.max_line_length: 70\nprogram.line_numbers: true\n"
      "program.line_number_step: 1\nprogram.line_end: lf\nprogram.percent: false\n"
      "program.max_blocks: 0\nprogram.max_program_bytes: 0\nprogram.tcp: false\n"
      "program.tilted_planes: false\n"
      "program.feed_mode: inverse_time\nprogram.feed_measure: xyz\n"
      "program.max_inverse_time_per_min: 9999.5\nprogram.max_feed_mm_per_min: 100000\n"
      "program.path_control: control\nprogram.retract: default\n"
      "program.start: none\nprogram.end: none\n"
      "program.clamp_tilt: none\nprogram.unclamp_tilt: none\n"
      "program.clamp_rotary: none\nprogram.unclamp_rotary: none\n"
      "program.preselect_tools: false\nprogram.through_coolant_on: none\nprogram.through_coolant_off: none\n"
      "link.default: serial:/dev/ttyACM0\nlink.receive_buffer_bytes: 1024\n"
      "link.bytes_per_s: 0\n"
      "wire.line_numbers: false\nwire.check: false\nwire.position_tolerance_mm: 0.1\n"
      "wire.position_tolerance_deg: 0.1\nwire.reprap_window: 0\n"
      "wire.tool_changes: guided\nwire.tool_length_tolerance_mm: 0.1\n"
      "wire.dnc.data_bits: 7\nwire.dnc.parity: even\nwire.dnc.stop_bits: 2\nwire.dnc.flow: xon_xoff\n"
      "wire.dnc.end_of_block: lf\nwire.dnc.leader_bytes: 0\nwire.dnc.trailer_bytes: 0\n"
      "wire.dnc.percent: true\nwire.dnc.wait_for_start: true\nwire.dnc.xon: 17\nwire.dnc.xoff: 19\n"
      "wire.ring.identity: 0\nwire.ring.window: 256\nwire.ring.mailbox: 384\nwire.ring.status: 512\n"
      "wire.ring.positions: 544\nwire.ring.heartbeat: 576\nwire.ring.low_word_first: "
      "false\nwire.ring.linear_exponent: -1\n"
      "wire.ring.rotary_exponent: -1\nwire.ring.watchdog_s: 1\n"
      "wire.drive.block: 25088\nwire.drive.words: 8\nwire.drive.low_word_first: false\n"
      "wire.drive.mode_word: 0\nwire.drive.mode: 1\n"
      "wire.drive.x.word: 1\nwire.drive.x.counts_per_mm: 1000\n"
      "wire.drive.y.word: -1\nwire.drive.y.counts_per_mm: 1000\n"
      "wire.drive.z.word: -1\nwire.drive.z.counts_per_mm: 1000\n"
      "wire.drive.tilt.word: -1\nwire.drive.tilt.counts_per_deg: 1000\n"
      "wire.drive.rotary.word: -1\nwire.drive.rotary.counts_per_deg: 1000\n"
      "wire.drive.feed_word: 3\nwire.drive.feed_counts_per_mm_per_min: 1\n"
      "wire.drive.rapid_mm_per_min: 3000\n"
      "wire.drive.acceleration_word: 4\nwire.drive.acceleration: 100\n"
      "wire.drive.deceleration_word: 5\nwire.drive.deceleration: 100\nwire.drive.trigger: 16\n"
      "wire.drive.status: 4099\nwire.drive.moving_mask: 4\nwire.drive.moving_value: 4\n"
      "wire.drive.fault_mask: 1\nwire.drive.settle_ms: 20\nwire.drive.stop: 24578\n"
      "wire.drive.stop_value: 64\n");
}

TEST(MachineProfile, TheWireIsRead) {
  const auto with = [](const std::string& wire) {
    return parse_machine(std::string(kGoodMachine) + wire, kMachinePath);
  };
  const auto drip = with(
      "wire: {dnc: {data_bits: 8, parity: odd, stop_bits: 1, flow: rts_cts, end_of_block: lf_cr_cr,\n"
      "  leader_bytes: 40, percent: false, wait_for_start: false, xon: 18, xoff: 20}}\n");
  ASSERT_TRUE(drip) << drip.error().message;
  EXPECT_EQ(drip->wire.drip.parity, Parity::kOdd);
  EXPECT_EQ(drip->wire.drip.flow, FlowControl::kRtsCts);
  EXPECT_EQ(drip->wire.drip.end_of_block, EndOfBlock::kLfCrCr);
  EXPECT_EQ(drip->wire.drip.xoff, 20);
  const auto map =
      with("wire: {ring: {window: 4096, low_word_first: true, linear_exponent: 5, watchdog_s: 0.5}}\n");
  ASSERT_TRUE(map) << map.error().message;
  EXPECT_EQ(map->wire.ring.window, 4096);
  EXPECT_TRUE(map->wire.ring.low_word_first);
  EXPECT_EQ(map->wire.ring.watchdog, 0.5);
  EXPECT_FALSE(with("wire: {dnc: {data_bits: 6}}\n"));
  EXPECT_FALSE(with("wire: {dnc: {xon: 19}}\n")) << "the same byte twice";
  EXPECT_FALSE(with("wire: {dnc: {parity: mark}}\n"));
  EXPECT_FALSE(with("wire: {ring: {window: 65536}}\n"));
  EXPECT_FALSE(with("wire: {ring: {words: 1}}\n"));
}

}  // namespace
}  // namespace tiltfeed
