// The campaign on the links that cannot prove what was executed: Grbl, RepRap and drip feed under every class
// of fault. Nothing resumes by itself, no run is stuck, and after each failure the journal leaves the job to
// the operator, with a range that holds the truth as long as what left the host arrived as it was.

#include <gtest/gtest.h>

#include <cstdio>

#include "daemon/journal/program_run.h"
#include "tests/peers/line_run.h"
#include "tests/peers/simulated_disk.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

constexpr double kStuck = 4000.0;  ///< s of link time: any of these runs takes seconds

constexpr double kPatience = 60.0;

struct FaultClass {
  const char* rule;
  bool alters;  ///< what the controller gets is another text, which plain text cannot show
};
constexpr FaultClass kClasses[] = {
    {"drop to-machine p=0.0005", true},
    {"duplicate to-machine p=0.0005", true},
    {"corrupt to-machine p=0.0005", true},
    {"insert to-machine p=0.0005", true},
    {"drop to-host p=0.001", false},
    {"duplicate to-host p=0.001", false},
    {"corrupt to-host p=0.001", false},
    {"insert to-host p=0.001", false},
    {"delay p=0.0003 for=0.4", false},
    {"lose-ok p=0.005", false},
    {"extra-ok p=0.005", false},
    {"wrong-line p=0.5", false},
    {"resend-storm p=0.05 value=4", false},
    {"silence p=0.0005 for=3", false},
    {"disconnect p=0.0003 for=2", false},
    {"xoff-stuck at=0.6 for=5", false},
    {"slow-read p=1", false},
    {"reset p=0.0004", false},
    {"alarm at=0.9", false},
};

/// What a broken sender would do; the campaign must see each.
enum class LineBug {
  kNone,
  kResumes,        ///< ends a hold that nobody has ended
  kForgetsFlight,  ///< takes what was not acknowledged for not sent
  kStartsAnew,     ///< does not look at what is on record
  kSendsOn,        ///< sends another line after the end
};

struct Totals {
  std::uint64_t runs = 0, faults = 0, done = 0, left = 0, wrong = 0;
};

/// One run with its journal; what is wrong with it, or nothing.
template <class Controller>
std::string run_once(const std::string& link, const std::string& text, const FaultClass& fault,
                     std::uint64_t seed, double bits, Totals& totals, LineBug bug) {
  const std::string path = "/tmp/tiltfeed_lines_" + std::to_string(::getpid()) + ".nc";
  std::ofstream(path) << text;
  std::istringstream in(text);
  const std::vector<sim::Block> program = *sim::read_program(in, path, 'A', 'C');
  std::vector<sim::Block> executed;
  Controller controller(wide_machine(), {}, {},
                        [&](const sim::TraceRow& row) { executed.push_back(row.command); });
  const auto script = sim::parse_fault_script("seed " + std::to_string(seed) + "\n" + fault.rule, "faults");
  EXPECT_TRUE(script) << script.error().message;
  const LinkSpec spec = *parse_link(link);
  VirtualLine<Controller> line(controller, *script, bits / spec.baud);

  const auto disk = std::make_shared<SimulatedDisk>();
  const ProgramRun run = *prepare_run(path, spec, 1);
  auto journal = Journal::open(journal_disk(disk));
  ResumeDecision fresh;
  fresh.way = ResumeWay::kFresh;
  StreamHooks hooks;
  bool stuck = false;
  double waits_since = 0.0;
  CommandQueue orders;
  hooks.commands = &orders;
  hooks.progress = [&](const SendState& state) {
    // A hold and a DC3 last until somebody acts: this operator stops what waits for a minute.
    const bool waits = state.phase == Phase::kHold || state.machine == "XOFF";
    if (!waits) waits_since = line.time;
    if (bug == LineBug::kResumes && state.phase == Phase::kHold) orders.push({Order::kResume});
    stuck = line.time > kStuck;
    return !stuck && line.time - waits_since < kPatience;
  };
  const auto report = run_job(run, fresh, *journal, line, line, hooks);
  const std::size_t said = line.said.size();
  std::string rest;
  if (bug == LineBug::kSendsOn && !report) static_cast<void>(line.exchange("G1X1F60\n", Time{0}, rest));
  // The machine goes on with what it has; nobody sends anything more.
  for (int i = 0; i < 20; ++i) static_cast<void>(line.exchange({}, std::chrono::seconds(1), rest));
  std::filesystem::remove(path);
  ++totals.runs;
  totals.faults += line.line.faults();
  ++(report ? totals.done : totals.left);

  if (stuck) return "stuck";
  if (line.said.size() != said) return "something was sent after the end";
  if (line.said.find('~') != std::string::npos || line.said.find("M108") != std::string::npos)
    return "resumed by itself";
  JournalContent record = read_journal(disk->file);
  if (bug == LineBug::kForgetsFlight) record.last->offered = record.last->acknowledged;
  ResumeDecision next = decide_resume(record, run.subject);
  if (bug == LineBug::kStartsAnew) next.way = ResumeWay::kFresh;
  if (next.way == ResumeWay::kContinue) return "the journal lets it go on by itself";
  if (!report && next.way == ResumeWay::kFresh && !executed.empty()) return "it would start anew";
  const bool plain = link.starts_with("dnc");
  if (fault.alters || (plain && std::string_view(fault.rule).starts_with("silence"))) return {};
  if (!executed.empty() && executed.back().op == sim::Op::kDwell) executed.pop_back();  // the barrier
  for (std::size_t i = 0; i < executed.size(); ++i)
    if (i >= program.size() || executed[i].op != program[i].op || executed[i].target.x != program[i].target.x)
      return "block " + std::to_string(i + 1) + " is not the program's";
  if (report && link.find("dnc") != 0)
    return executed.size() == program.size() ? "" : "done, but not all of it";
  const std::uint64_t newest = executed.empty() ? 0 : program[executed.size() - 1].line;
  std::uint64_t sure = 0;  // blocks of the lines that are said to have run
  while (sure < program.size() && program[sure].line <= next.executed) ++sure;
  if (sure > executed.size() || newest > next.may_have)
    return "the operator is told " + std::to_string(next.executed) + " to " + std::to_string(next.may_have) +
           ", in truth " + std::to_string(newest);
  return {};
}

template <class Controller>
Totals campaign(const std::string& link, double bits, double each, std::uint64_t seeds,
                LineBug bug = LineBug::kNone) {
  const std::string text = short_blocks(250, each);
  Totals totals;
  for (const FaultClass& fault : kClasses)
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
      const std::string wrong = run_once<Controller>(link, text, fault, seed, bits, totals, bug);
      if (wrong.empty()) continue;
      ++totals.wrong;
      if (bug != LineBug::kNone) return totals;
      if (totals.wrong <= 5) ADD_FAILURE() << fault.rule << ", seed " << seed << ": " << wrong;
    }
  if (bug != LineBug::kNone) return totals;
  EXPECT_GT(totals.left, 0u);
  EXPECT_GT(totals.done, 0u);
  std::printf("%s: %llu runs, %llu faults, %llu done, %llu left to the operator, %llu wrong\n", link.c_str(),
              static_cast<unsigned long long>(totals.runs), static_cast<unsigned long long>(totals.faults),
              static_cast<unsigned long long>(totals.done), static_cast<unsigned long long>(totals.left),
              static_cast<unsigned long long>(totals.wrong));
  return totals;
}

constexpr std::uint64_t kSeeds = 40;

// (stream.h, properties 2 to 5; session.h, property 4)
TEST(LineCampaign, Grbl) {
  EXPECT_EQ(campaign<sim::GrblController>("grbl:/dev/null@115200", 10, 0.004, kSeeds).wrong, 0u);
}

// (stream.h, properties 2 to 5; session.h, property 4)
TEST(LineCampaign, RepRap) {
  EXPECT_EQ(campaign<sim::RepRapController>("reprap:/dev/null@115200", 10, 0.004, kSeeds).wrong, 0u);
}

// (stream.h, properties 2, 4 and 5; session.h, property 4)
TEST(LineCampaign, DripFeed) {
  EXPECT_EQ(campaign<sim::DripController>("dnc:/dev/null@38400", 11, 0.01, kSeeds).wrong, 0u);
}

TEST(LineCampaign, EverySeededBugIsFound) {
  for (const LineBug bug :
       {LineBug::kResumes, LineBug::kForgetsFlight, LineBug::kStartsAnew, LineBug::kSendsOn})
    EXPECT_GT(campaign<sim::GrblController>("grbl:/dev/null@115200", 10, 0.004, kSeeds, bug).wrong, 0u)
        << "bug " << static_cast<int>(bug) << " passes unseen";
}

}  // namespace
}  // namespace tiltfeed
