// Two jobs whose plans end together: one that this service plans, and one that another service has planned.
// Their programs are read one at a time. Planner and proof are the real ones; the planner waits, and so does
// the thread that reads a program, until the test lets them go on.

#include <dlfcn.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cctype>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <iostream>

#include "daemon/files/sha256.h"
#include "daemon/plan/plan_program.h"
#include "tests/peers/served_jobs.h"

namespace {

const std::thread::id main_thread = std::this_thread::get_id();
/// A program of this name is opened by no other thread than the first, until it is let go.
std::atomic<const char*> held{nullptr};
std::atomic<bool> waits{false};

constexpr const char* kHold = "hold";  // in a job's folder: its planner does not begin

void let_go() {
  held = nullptr;
  held.notify_all();
}

}  // namespace

extern "C" int open(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const unsigned mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(more, unsigned) : 0;
  va_end(more);
  const char* const name = held;
  if (name != nullptr && std::this_thread::get_id() != main_thread && std::strstr(path, name) != nullptr) {
    waits = true;
    held.wait(name);
  }
  return reinterpret_cast<int (*)(const char*, int, ...)>(::dlsym(RTLD_NEXT, "open"))(path, flags, mode);
}

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

constexpr const char* kMachine = SOURCE_DIR "/config/machines/generic-ac.yaml";

std::string plate() {
  const int quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                           {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  std::string text = "solid plate\n";
  for (const auto& quad : quads)
    for (const auto& facet : {std::array{0, 1, 2}, std::array{0, 2, 3}}) {
      text += "facet normal 0 0 0\nouter loop\n";
      for (const int corner : facet) {
        const int v = quad[corner];
        text += std::string("vertex ") + (v & 1 ? "10 " : "-10 ") + (v & 2 ? "10 " : "-10 ") +
                (v & 4 ? "0\n" : "-5\n");
      }
      text += "endloop\nendfacet\n";
    }
  return text + "endsolid plate\n";
}

const std::string kJob =
    "part: {name: plate, stl: part.stl}\n"
    "cutter: {type: ball, diameter_mm: 6, length_mm: 80, shank_length_mm: 30}\n"
    "axis: {mode: point, sense: outward, origin_mm: [0, 0, -60]}\n"
    "pattern: {along: x, direction: zigzag, side_step_mm: 4}\n"
    "tolerance_mm: 0.02\nclearance_mm: 5\napproach_mm: 1\n"
    "feeds: {cut_mm_per_min: 1000, plunge_mm_per_min: 300, spindle_rpm: 9000}\n"
    "setup: {part_zero_mm: [0, 0, 0]}\nmachine: " +
    std::string(kMachine) + "\n";

/// Children of this process that have ended, and of which nobody has asked how.
int ended_children() {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    if (std::isdigit(static_cast<unsigned char>(entry.path().filename().string().front())) == 0) continue;
    const std::string stat = file_text(entry.path().string() + "/stat");
    const std::size_t name_end = stat.rfind(')');
    char state = 0;
    int parent = 0;
    if (name_end != stat.npos && std::sscanf(stat.c_str() + name_end + 1, " %c %d", &state, &parent) == 2 &&
        parent == ::getpid() && state == 'Z')
      ++count;
  }
  return count;
}

class PlanEnds : public testing::Test, protected ServedJobs {
 protected:
  PlanEnds() : ServedJobs("plan_ends", std::chrono::seconds(300)) {
    folder_.write("part.stl", plate());
    folder_.write("job.yaml", kJob);
    const std::string file =
        folder_.write("service.yaml", "machine: " + std::string(kMachine) + "\nlink: grbl:" + folder_.path +
                                          "/absent\nspool: spool\nsocket: s\n");
    const auto service = load_service_config(file);
    EXPECT_TRUE(service) << service.error().message;
    auto jobs = JobService::open(*service, [] {});
    EXPECT_TRUE(jobs) << jobs.error().message;
    jobs_ = std::make_unique<JobService>(std::move(*jobs));
    jobs_->on_shop_news([] {});
    EXPECT_TRUE(jobs_->read_plans());
    EXPECT_TRUE(jobs_->plan_helpers(true));
  }
  ~PlanEnds() override {
    let_go();
    leave();
  }

  std::string folder_of(int job) const { return folder_.path + "/spool/jobs/" + std::to_string(job); }
  void submit() {
    ApiRequest request;
    request.op = ApiOp::kSubmit;
    std::vector<int> files;
    for (const char* name : {"job.yaml", "part.stl"})
      files.push_back(::open((folder_.path + "/" + name).c_str(), O_RDONLY | O_CLOEXEC));
    const nlohmann::json answer = ask(request, files);
    EXPECT_TRUE(good(answer)) << answer.dump();
    for (const int file : files) ::close(file);
  }
  /// Job 1 is planned. The planner of job 2 waits; another service has planned job 3 as job 1 was.
  void plan_three() {
    submit();
    until([&] { return state(1) == "ready"; });
    submit();
    std::ofstream(folder_of(2) + "/" + kHold) << "";
    until([&] { return state(2) == "planning"; });
    submit();
    until([&] { return jobs_->read_plans()->asks.size() == 1; });
    const std::string order = jobs_->read_plans()->asks.front().id;
    ASSERT_TRUE(jobs_->plan_told(order, {PlanState::kTaken, "north", 0, "", ""}));
    std::vector<int> made;
    for (const std::string& name : plan_outputs())
      made.push_back(::open((folder_of(1) + "/" + name).c_str(), O_RDONLY | O_CLOEXEC));
    ASSERT_TRUE(jobs_->plan_returned(order, "north", "files " + hex(sha256(file_text(kMachine))), made));
    for (const int file : made) ::close(file);
    ASSERT_EQ(state(3), "planning");
  }
  /// The end of job 2's plan is there to be taken, besides `others`.
  void end_plan(int others) {
    std::filesystem::remove(folder_of(2) + "/" + kHold);
    while (ended_children() < 1 + others) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  void expect_both() {
    until([&] { return state(2) == "ready" && state(3) == "ready"; });
    EXPECT_EQ(field(2, "note"), "planned");
    EXPECT_EQ(field(3, "note"), "planned by north, proved here");
    EXPECT_EQ(ask(ApiOp::kShow, 2).at("blocks"), ask(ApiOp::kShow, 3).at("blocks"));
  }
};

TEST_F(PlanEnds, APlanEndsWhileAnothersProgramIsRead) {
  held = "/jobs/3/program.nc";
  plan_three();
  until([&] { return waits.load(); });
  end_plan(0);
  for (int turn = 0; turn < 5; ++turn) jobs_->tick();
  EXPECT_EQ(state(2), "planning") << "its program waits for its turn";
  EXPECT_EQ(state(3), "planning");
  let_go();
  expect_both();
}

TEST_F(PlanEnds, PlanAndProofHaveEndedInOneTurn) {
  plan_three();
  end_plan(1);
  expect_both();
}

}  // namespace
}  // namespace tiltfeed

/// The service starts its own program anew to plan: this one is the planner then.
int main(int argc, char** argv) {
  if (argc > 1 && std::string_view(argv[1]) == "plan") {
    const int service = ::getppid();
    while (::access(kHold, F_OK) == 0 && ::getppid() == service) ::usleep(2000);
    tiltfeed::daemon::PlanFiles files;
    files.job = "job.yaml", files.stl = "part.stl", files.machine = tiltfeed::kMachine;
    files.program = "program.nc", files.cl = "path.cls", files.report = "report.json";
    files.map = "block.map";
    files.alone = true;
    const auto planned = tiltfeed::daemon::plan_program(files, {});
    std::cerr << (planned ? *planned : planned.error().message) << "\n";
    return planned ? 0 : 1;
  }
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
