// The link to a plain drive against the simulated one, over a wire that loses, delays and refuses: no move is
// made twice, none is left out, nothing resumes by itself.

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "config/machine_profile.h"
#include "daemon/journal/run_recorder.h"
#include "daemon/machine/stop_machine.h"
#include "daemon/protocol/drive_session.h"
#include "daemon/stream/session_feed.h"
#include "sim/controller/drive_controller.h"
#include "sim/wire/faulty_line.h"
#include "tests/peers/simulated_disk.h"
#include "tests/shapes/wide_machine.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

/// Modbus frames in made-up time, 2 ms each, without bytes: what becomes of a frame says the fault script.
class DriveWire : public Link, public Clock {
 public:
  explicit DriveWire(const sim::DriveOptions& options = {}, const std::string& faults = "")
      : drive(wide_machine(), options, [this](const sim::TraceRow& row) { executed.push_back(row.command); }),
        line(*sim::parse_fault_script(faults, "faults")) {}

  Time now() override { return std::chrono::duration_cast<Time>(std::chrono::duration<double>(time)); }

  Result<std::size_t> exchange(std::string_view out, Time wait, std::string& in) override {
    if (time >= dies_at) return fail(Code::kLink, "killed");
    if (out.empty()) {
      pass(std::max(1e-4, std::chrono::duration<double>(wait).count()));
      return 0;
    }
    pass(0.002);
    in += pack_reply(ask(unpack_request(out)));
    return out.size();
  }

  void pass(double span) { drive.advance(time += span); }

  sim::DriveController drive;
  sim::FaultyLine line;
  std::vector<sim::Block> executed;
  std::vector<std::vector<std::uint16_t>> written;  ///< moves, as they arrived
  double time = 0.0, dies_at = 1e9;
  std::uint64_t stops = 0, lost_writes = 0;

 private:
  ModbusReply ask(const ModbusRequest& request) {
    const sim::FrameFate fate = line.frame();
    const bool move = request.words.size() > 1;
    const bool lost =
        fate.lose_request || fate.lose_reply || fate.wrong_unit || fate.half_frame || fate.late > 0.0;
    lost_writes += move && lost;
    ModbusReply reply;
    if (lost) pass(0.3);  // the host's patience
    if (fate.lose_request) return reply;
    if (fate.exception != 0) return reply.outcome = static_cast<std::uint8_t>(fate.exception), reply;
    sim::Access access = sim::Access::kOk;
    if (!request.words.empty()) access = drive.write(request.write_address, request.words);
    if (move) written.push_back(request.words);
    stops += !request.words.empty() && !move;
    reply.words.resize(request.read_count);
    if (request.read_count > 0) access = drive.read(request.read_address, reply.words);
    reply.outcome = lost ? kReplyMissing : static_cast<std::uint8_t>(access);
    if (reply.outcome != kReplyOk) reply.words.clear();
    return reply;
  }
};

/// X to and fro; each place once.
std::string strokes(int count) {
  std::string text = "G21 G90 G94\nG0 X0 Y5 Z50 A0 C0\n";
  for (int i = 1; i <= count; ++i)
    text += "G1 X" + std::to_string((i % 2 != 0 ? 1 : -1) * (1.0 + i * 0.01)) + " F6000\n";
  return text + "M2\n";
}

struct Ran {
  Result<SendReport> report;
  SendState last;
  ResumeDecision decision;
};

Ran run(DriveWire& wire, const std::string& program, DriveMap map = {},
        const std::function<void(const SendState&, CommandQueue&)>& watch = {}) {
  static int count = 0;
  const std::string path =
      "/tmp/tiltfeed_drive_" + std::to_string(::getpid()) + "_" + std::to_string(++count) + ".nc";
  std::ofstream(path) << program;
  LinkSpec link = *parse_link("drive-rtu:/dev/null@115200/1");
  link.profile.drive = map;
  Ran ran;
  const auto disk = std::make_shared<SimulatedDisk>();
  Journal journal = *Journal::open(journal_disk(disk));
  RunSubject subject;
  subject.total = *count_blocks(path, link.kind);
  subject.link = link.kind;
  RunRecorder recorder = *RunRecorder::begin(journal, subject);
  CommandQueue queue;
  StreamHooks hooks;
  hooks.commands = &queue;
  hooks.reserve = [&](std::uint64_t next, std::uint64_t) { return recorder.reserve(next, wire.now()); };
  hooks.progress = [&](const SendState& state) {
    ran.last = state;
    if (watch) watch(state, queue);
    EXPECT_TRUE(recorder.progress(state, wire.now()));
    return wire.time < 3000.0;
  };
  ran.report = send_over(path, link, wire, wire, {}, hooks);
  ran.decision = decide_resume(Journal::open(journal_disk(disk))->content(), subject);
  std::filesystem::remove(path);
  return ran;
}

/// What was executed is the program's begin, each move once.
void expect_begin(const DriveWire& wire, std::size_t most) {
  ASSERT_LE(wire.executed.size(), most);
  for (std::size_t i = 0; i < wire.executed.size(); ++i) {
    const int n = static_cast<int>(i);
    const double x = i == 0 ? 0.0 : (n % 2 != 0 ? 1 : -1) * (1.0 + n * 0.01);
    ASSERT_NEAR(wire.executed[i].target.x, x, 1e-9) << "move " << i;
  }
}

TEST(Drive, EachMoveOnceInOrderAndTheNextOneOnlyWhenItStands) {
  DriveWire wire;
  const Ran ran = run(wire, strokes(200));
  ASSERT_TRUE(ran.report) << ran.report.error().message;
  EXPECT_FALSE(ran.report->executed) << "a drive that numbers nothing proves nothing";
  EXPECT_EQ(wire.executed.size(), 201u);
  expect_begin(wire, 201);
  EXPECT_EQ(wire.drive.moves(), 201u);
  EXPECT_EQ(wire.drive.replaced(), 0u);
  EXPECT_EQ(wire.stops, 0u);
}

TEST(Drive, ItsWordsAreThoseOfTheProfile) {
  DriveMap map;
  map.words = 10;
  map.axes[2] = {7, -200.0};
  map.feed_counts = 0.5;
  NumericBlock block;
  block.op = BlockOp::kFeed;
  block.x = -1.5;
  block.z = 2.0;
  block.feed = 600.0;
  DriveEncoder encoder(map);
  EXPECT_EQ(*encoder.encode(block),
            (std::vector<std::uint16_t>{1, 0xFFFF, 0xFA24, 300, 100, 100, 0, 0xFFFF, 0xFE70, 16}));
  block.inverse_time = true;  // 3 mm and 4 mm in half a minute
  block.x = 1.5;
  block.z = 6.0;
  block.feed = 2.0;
  map.low_word_first = true;
  EXPECT_EQ((*encoder.encode(block))[3], 5);
  DriveEncoder low(map);
  block.inverse_time = false;
  EXPECT_EQ((*low.encode(block))[1], 1500);
  EXPECT_EQ((*low.encode(block))[2], 0);
}

TEST(Drive, ItsProfileIsReadAndEveryBadPlaceRefused) {
  const std::string path = SOURCE_DIR "/config/machines/generic-ac.yaml";
  std::ifstream in(path);
  const std::string example((std::istreambuf_iterator<char>(in)), {});
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = example;
    const std::size_t at = text.find(from, text.find("\n  drive:"));
    EXPECT_NE(at, std::string::npos) << from;
    return parse_machine(text.replace(at, from.size(), to), path);
  };
  const auto profile = with("z: {word: -1, counts_per_mm: 1000}", "z: {word: 5, counts_per_mm: -200}");
  ASSERT_FALSE(profile) << "word 5 is the deceleration's";
  const auto wide = with("words: 8 ", "words: 12");
  ASSERT_TRUE(wide) << wide.error().message;
  EXPECT_EQ(wide->wire.drive.words, 12);
  const auto turned = with("x: {word: 1, counts_per_mm: 1000}", "x: {word: 1, counts_per_mm: -200}");
  ASSERT_TRUE(turned) << turned.error().message;
  EXPECT_EQ(turned->wire.drive.axes[0].counts, -200.0);
  const std::pair<const char*, const char*> bad[] = {
      {"z: {word: -1,", "z: {word: 2,"},
      {"z: {word: -1,", "z: {word: 6,"},
      {"words: 8", "words: 3"},
      {"feed_word: 3", "feed_word: 7"},
      {"x: {word: 1,", "x: {word: -1,"},
      {"mode: 1", "mode: 65536"},
      {"moving_value: 4", "moving_value: 8"},
      {"counts_per_mm: 1000", "counts_per_mm: 0"},
      {"tilt: {word: -1, counts_per_deg", "tilt: {word: -1, counts_per_mm"}};
  for (const auto& [from, to] : bad) {
    const auto refused = with(from, to);
    ASSERT_FALSE(refused) << to;
    EXPECT_NE(refused.error().message.find("wire.drive"), std::string::npos) << refused.error().message;
  }
}

TEST(Drive, ALostAnswerToAWriteThatWasDoneIsNotRepeated) {
  for (const char* fault : {"lose-reply", "wrong-unit", "half-frame", "late-reply", "lose-request"}) {
    DriveWire wire({}, "");
    bool spoilt = false;
    const Ran ran = run(wire, strokes(200), {}, [&](const SendState& state, CommandQueue&) {
      if (state.executed < 20 || spoilt) return;
      spoilt = true;
      wire.line = sim::FaultyLine(*sim::parse_fault_script(std::string(fault) + " p=0.4\n", "faults"));
    });
    ASSERT_FALSE(ran.report) << fault;
    EXPECT_NE(ran.report.error().message.find("nothing is sent again"), std::string::npos)
        << ran.report.error().message;
    EXPECT_EQ(ran.last.loss, Loss::kWire);
    EXPECT_EQ(ran.decision.way, ResumeWay::kUncertain);
    wire.pass(10.0);
    expect_begin(wire, 201);
    // The uncertain range has what was executed in it.
    EXPECT_LE(ran.decision.executed, wire.executed.size());
    EXPECT_GE(ran.decision.may_have, wire.executed.size());
  }
}

TEST(Drive, NoFaultMakesAMoveTwiceOrLeavesOneOut) {
  std::uint64_t faults = 0, lost = 0, done = 0, cut_off = 0;
  for (int seed = 1; seed <= 1600; ++seed) {
    DriveWire wire({}, "seed " + std::to_string(seed) +
                           "\nlose-reply p=0.0007\nlose-request p=0.0007\nlate-reply p=0.0005 for=1\n"
                           "wrong-unit p=0.0005\nhalf-frame p=0.0005\nexception p=0.002 value=6\n");
    const Ran ran = run(wire, strokes(60));
    wire.pass(10.0);
    faults += wire.line.faults();
    lost += wire.lost_writes;
    expect_begin(wire, 61);
    // Each move that arrived is another place than the one before: none came twice.
    for (std::size_t i = 1; i < wire.written.size(); ++i) ASSERT_NE(wire.written[i], wire.written[i - 1]);
    EXPECT_LE(wire.lost_writes, 1u) << "after the first one nothing may follow";
    if (ran.report) {
      ++done;
      EXPECT_EQ(wire.executed.size(), 61u);
      continue;
    }
    ++cut_off;
    EXPECT_NE(ran.decision.way, ResumeWay::kContinue) << "resumed by itself";
    EXPECT_LE(ran.decision.executed, wire.executed.size());
    EXPECT_GE(ran.decision.may_have, wire.executed.size());
    EXPECT_LT(wire.time, 100.0) << "stuck";
  }
  EXPECT_GT(faults, 1000u);
  EXPECT_GT(lost, 30u);
  EXPECT_GT(done, 50u);
  EXPECT_GT(cut_off, 50u);
}

TEST(Drive, ASlowStatusIsNotTakenForAStand) {
  sim::DriveOptions slow;
  slow.reaction = 0.05;
  DriveWire late(slow);
  DriveMap hasty;
  hasty.settle = 0.01;
  static_cast<void>(run(late, strokes(20), hasty));
  EXPECT_GT(late.drive.replaced(), 0u) << "this drive must be one whose status comes late";
  DriveWire wire(slow);
  DriveMap map;
  map.settle = 0.06;
  ASSERT_TRUE(run(wire, strokes(20), map).report);
  EXPECT_EQ(wire.executed.size(), 21u);
  EXPECT_EQ(wire.drive.replaced(), 0u);
}

// (session.h, property 4)
TEST(Drive, HoldStopsItAndTheOperatorsResumeGoesOnToTheSamePlace) {
  DriveWire wire;
  double asked = 0.0, held = 0.0;
  double stood_at = 0.0;
  bool resumed = false;
  const std::string program = "G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X100 F600\nG1 X90 F600\nM2\n";
  const Ran ran = run(wire, program, {}, [&](const SendState& state, CommandQueue& queue) {
    if (asked == 0.0 && wire.time > 3.0) asked = wire.time, queue.push({Order::kHold});
    if (held == 0.0 && state.machine == "Hold") held = wire.time, stood_at = wire.drive.motion().position().x;
    if (held > 0.0 && wire.time < held + 2.0) {
      EXPECT_EQ(wire.drive.motion().position().x, stood_at) << "moved in a hold";
    }
    if (held > 0.0 && wire.time > held + 2.0 && !resumed) resumed = true, queue.push({Order::kResume});
  });
  ASSERT_TRUE(ran.report) << ran.report.error().message;
  EXPECT_GT(held, 0.0);
  EXPECT_LT(held - asked, 0.2);
  EXPECT_GT(stood_at, 1.0);
  EXPECT_LT(stood_at, 99.0);
  ASSERT_EQ(wire.executed.size(), 3u);
  EXPECT_EQ(wire.executed[1].target.x, 100.0);
  EXPECT_EQ(wire.executed[2].target.x, 90.0);
}

TEST(Drive, StopAlarmToolChangeAndDwell) {
  DriveWire wire;
  const Ran stopped = run(wire, strokes(100), {}, [](const SendState& state, CommandQueue& queue) {
    if (state.executed > 20) queue.push({Order::kStop});
  });
  ASSERT_FALSE(stopped.report);
  EXPECT_EQ(stopped.last.phase, Phase::kStopped);
  EXPECT_TRUE(wire.drive.motion().idle());
  EXPECT_GE(wire.stops, 1u);

  DriveWire alarm;
  const Ran failed = run(alarm, strokes(100), {}, [&](const SendState& state, CommandQueue&) {
    if (state.executed > 20) alarm.drive.raise_alarm();
  });
  EXPECT_EQ(failed.last.phase, Phase::kAlarm);

  DriveWire waits;
  double asked = 0.0;
  const Ran waited = run(waits, "G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nM0\nG4 P2\nG1 X1 F600\nM2\n", {},
                         [&](const SendState& state, CommandQueue& queue) {
                           if (state.phase != Phase::kToolChange) return;
                           EXPECT_EQ(waits.executed.size(), 1u);
                           if (asked == 0.0) asked = waits.time;
                           if (waits.time > asked + 60.0) queue.push({Order::kResume});
                         });
  ASSERT_TRUE(waited.report) << waited.report.error().message;
  EXPECT_GT(waits.time, asked + 62.0);
  EXPECT_EQ(waits.executed.size(), 2u);
}

TEST(Drive, RefusesBeforeAnythingMovesWhatItHasNot) {
  const struct {
    const char* program;
    const char* why;
  } cases[] = {{"G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X1 F600\nM3 S100\nM2\n", "switch by hand"},
               {"G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 Y1 F600\nM2\n", "Y moves"},
               {"G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X1 F99999\nM2\n", "does not fit"},
               {"G21 G90 G93\nG1 X0 Y0 Z0 A0 C0 F60\nM2\n", "first move"}};
  for (const auto& c : cases) {
    DriveWire wire;
    const Ran ran = run(wire, c.program);
    ASSERT_FALSE(ran.report) << c.program;
    EXPECT_NE(ran.report.error().message.find(c.why), std::string::npos) << ran.report.error().message;
    EXPECT_TRUE(wire.written.empty());
  }
  DriveMap elsewhere;
  elsewhere.status = 0x1004;
  DriveWire wire;
  const Ran ran = run(wire, strokes(3), elsewhere);
  EXPECT_NE(ran.report.error().message.find("wire.drive"), std::string::npos);
  EXPECT_TRUE(wire.written.empty());
}

TEST(Drive, F20_IsStoppedWhenItsServiceDies) {
  DriveWire wire;
  wire.dies_at = 3.0;
  ASSERT_FALSE(run(wire, "G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X100 F600\nM2\n").report);
  wire.dies_at = 1e9;
  EXPECT_FALSE(wire.drive.motion().idle());
  wire.line = sim::FaultyLine(*sim::parse_fault_script("lose-request p=0.3\nlose-reply p=0.3\n", "faults"));
  LinkSpec link = *parse_link("drive-rtu:/dev/null@115200/1");
  const Result<std::string> stopped = stop_machine(link, wire, wire);
  ASSERT_TRUE(stopped) << stopped.error().message;
  EXPECT_TRUE(wire.drive.motion().idle());
  wire.pass(100.0);
  EXPECT_EQ(wire.executed.size(), 1u);
}

TEST(DriveSession, AResumeBeforeTheStandActsAtTheStandUnlessAHoldFollows) {
  for (const bool hold_again : {false, true}) {
    Time now{0};
    DriveSession session({3, DriveMap{}}, now);
    std::uint16_t status = 0;  // bit 2: it moves
    std::vector<std::uint16_t> written;
    const auto turn = [&] {
      const std::string request(session.output(now));
      if (!request.empty()) {
        const ModbusRequest asked = unpack_request(request);
        if (!asked.words.empty()) written.push_back(asked.write_address);
        session.sent(request.size());
        session.receive(pack_reply({kReplyOk, std::vector<std::uint16_t>(asked.read_count, status)}), now);
      }
      now += std::chrono::milliseconds(30);
    };
    turn();
    ASSERT_EQ(session.phase(), Phase::kRun);
    NumericBlock block;
    block.x = 10.0;
    session.push(block);
    turn();
    status = 4;
    turn();
    session.command({Order::kHold}, now);
    turn();  // the stop value
    turn();  // it brakes
    session.command({Order::kResume}, now);
    if (hold_again) session.command({Order::kHold}, now);
    turn();
    ASSERT_EQ(session.phase(), Phase::kHold);
    status = 0;
    for (int i = 0; i < 3; ++i) turn();
    EXPECT_EQ(session.phase(), hold_again ? Phase::kHold : Phase::kRun);
    EXPECT_EQ(written.size(), hold_again ? 2u : 3u) << "the move again, and the stop";
  }
}

/// A drive that takes the stop and goes on saying that it moves: the run ends, and says so.
TEST(DriveSession, AStopOfADriveThatNeverStandsEnds) {
  Time now{0};
  DriveSession session({3, DriveMap{}}, now);
  std::uint16_t status = 0;
  std::size_t stops = 0;
  const auto turn = [&] {
    const std::string request(session.output(now));
    if (!request.empty()) {
      const ModbusRequest asked = unpack_request(request);
      stops += asked.words.size() == 1;
      session.sent(request.size());
      session.receive(pack_reply({kReplyOk, std::vector<std::uint16_t>(asked.read_count, status)}), now);
    }
    now += std::chrono::milliseconds(30);
  };
  turn();
  NumericBlock block;
  block.x = 10.0;
  session.push(block);
  turn();
  status = 4;  // bit 2: it moves
  turn();
  session.command({Order::kStop}, now);
  const Time asked = now;
  while (!is_final(session.phase()) && now - asked < std::chrono::seconds(60)) turn();
  ASSERT_TRUE(is_final(session.phase()));
  EXPECT_NE(session.phase(), Phase::kStopped) << "it does not stand";
  EXPECT_GE(now - asked, std::chrono::seconds(10));
  EXPECT_NE(session.error().message.find("still says after 10 s that it moves (status 4)"), std::string::npos)
      << session.error().message;
  EXPECT_EQ(session.state().uncertain.first, session.state().uncertain.last);
  turn();
  EXPECT_GE(stops, 2u) << "it is told again";
}

/// A drive that is switched off in a move stands when it is back: that is no end of the move.
TEST(DriveSession, ADriveThatIsSilentInAMoveHasNotDoneIt) {
  for (const int missing : {2, 4}) {
    Time now{0};
    DriveSession session({3, DriveMap{}}, now);
    std::uint16_t status = 0;
    int silent = 0;
    std::size_t moves = 0;
    const auto turn = [&] {
      const std::string request(session.output(now));
      now += std::chrono::milliseconds(30);
      if (request.empty()) return;
      const ModbusRequest asked = unpack_request(request);
      moves += asked.words.size() > 1;
      session.sent(request.size());
      if (silent > 0) {
        --silent, now += std::chrono::milliseconds(300);  // the host's patience
        return session.receive(pack_reply({kReplyMissing, {}}), now);
      }
      session.receive(pack_reply({kReplyOk, std::vector<std::uint16_t>(asked.read_count, status)}), now);
    };
    turn();
    for (int k = 0; k < 2; ++k) {
      NumericBlock block;
      block.line = static_cast<std::uint32_t>(k + 1), block.x = 10.0 * (k + 1);
      session.push(block);
    }
    turn();
    status = 4;
    turn();
    silent = missing;
    while (silent > 0) turn();
    status = 0;
    for (int k = 0; k < 10; ++k) turn();
    const bool back_in_time = missing == 2;
    EXPECT_EQ(is_final(session.phase()), !back_in_time);
    EXPECT_EQ(moves, back_in_time ? 2u : 1u);
    if (back_in_time) continue;
    EXPECT_NE(session.error().message.find("may have been switched off"), std::string::npos)
        << session.error().message;
    EXPECT_EQ(session.state().executed, 0u);
    EXPECT_EQ(session.state().uncertain.first, 1u);
    EXPECT_EQ(session.state().uncertain.last, 1u);
  }
}

}  // namespace
}  // namespace tiltfeed
