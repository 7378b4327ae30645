// The machine's commands through the service: beside jobs, refused by name while one runs. The simulated
// machine is behind TCP. What is waited for are states that last and counts that only grow.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "daemon/service/job_service.h"
#include "tests/peers/operator_shop.h"
#include "tests/peers/served_jobs.h"
#include "tests/peers/tcp_machine.h"
#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

using nlohmann::json;

class MachineService : public testing::Test, protected ServedJobs {
 protected:
  explicit MachineService(const std::string& faults = "")
      : ServedJobs("machine_service", std::chrono::seconds(120)), machine_(shop_machine(), {}, faults, 4.0) {
    open(shop_machine(), "grbl-tcp:" + machine_.place);
  }
  ~MachineService() override { leave(); }

  json ask(const ApiRequest& request) {
    // As the socket does it: what cannot be said in a line cannot be asked.
    const auto read = parse_request(write_request(request).substr(0, write_request(request).size() - 1));
    EXPECT_TRUE(read) << read.error().message;
    if (const auto at_once = jobs_->order(*read)) return json::parse(*at_once);
    return ServedJobs::ask(*read);
  }
  json order(const std::string& command, const std::string& words = "") {
    ApiRequest request;
    request.op = ApiOp::kMachine;
    request.command = command;
    request.words = words;
    return ask(request);
  }
  json follow(std::uint64_t number, bool held = false, bool stop = false) {
    ApiRequest request;
    request.op = ApiOp::kMachine;
    request.order = number;
    request.held = held;
    request.stop = stop;
    return ask(request);
  }
  /// To its end.
  json say(const std::string& command, const std::string& words = "") {
    json answer = order(command, words);
    if (!answer.contains("order")) return answer;
    const auto number = answer["order"];
    until([&] { return !(answer = follow(number)).contains("in_work"); });
    return answer;
  }
  json job(ApiOp op, std::uint64_t number = 0) {
    ApiRequest request;
    request.op = op;
    request.job = number;
    return ask(request);
  }
  std::string state(std::uint64_t number) { return job(ApiOp::kShow, number).value("state", ""); }
  void submit_ready(std::uint64_t number, int count) {
    std::string text = "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nG1 F6000\n";
    for (int i = 0; i < count; ++i) text += "G1 X" + std::to_string(i % 2 * 50) + "\n";
    EXPECT_EQ(submit_text(text + "M2\n")["job"], number);
    until([&] { return state(number) == "ready"; });
  }
  static bool has(const json& answer, const char* what) {
    return answer.value("error", "").find(what) != std::string::npos;
  }

  TcpMachine machine_;
};

class SilentMachine : public MachineService {
 protected:
  SilentMachine() : MachineService("silence at=4 for=3600\n") {}
};

TEST_F(MachineService, DoesWhatThePlainCommandDoes) {
  const json status = say("status");
  ASSERT_TRUE(good(status)) << status;
  EXPECT_EQ(status["result"]["state"], "Idle");
  const json jog = say("jog", "X10 Y-2.5 F6000");
  ASSERT_TRUE(good(jog)) << jog;
  EXPECT_EQ(jog["result"]["program"]["X"], 10.0);
  EXPECT_EQ(machine_.x, 10.0);
  EXPECT_TRUE(has(say("jog", "X999"), "its travel ends at 200"));
  EXPECT_TRUE(has(say("fly"), "no command for a machine"));
  EXPECT_TRUE(has(follow(1), "not the newest"));
  EXPECT_TRUE(good(say("offsets", "G55 here X0")));
}

TEST_F(MachineService, WhileAProgramRunsOnlyWhatIsSafeIsPossible) {
  submit_ready(1, 100000);
  for (const ApiOp op : {ApiOp::kHold, ApiOp::kResume, ApiOp::kStop})
    EXPECT_TRUE(has(job(op), "no job is on the machine"));
  ASSERT_TRUE(good(job(ApiOp::kStart, 1)));
  until([&] { return machine_.executed > 3; });
  for (const char* name : {"jog", "home", "unlock", "offsets", "probe", "settings", "console", "tool"}) {
    const json refused = order(name, "X1");
    EXPECT_TRUE(has(refused, (std::string(name) + " is not possible while job 1 is on the machine").c_str()))
        << refused;
  }
  const json status = order("status");
  ASSERT_TRUE(good(status)) << status;
  EXPECT_EQ(status["result"]["job"], 1);
  EXPECT_EQ(status["result"]["program"]["Z"], 50.0) << status;
  EXPECT_TRUE(has(order("override", "rapid 70"), "override: "));
  ASSERT_TRUE(good(order("override", "feed 55")));
  until([&] { return order("status")["result"].value("/override/feed"_json_pointer, 0) == 55; });
  ASSERT_TRUE(good(order("override", "rapid 25")));
  until([&] { return order("status")["result"].value("/override/rapid"_json_pointer, 0) == 25; });
  ASSERT_TRUE(good(order("override", "spindle 120")));
  until([&] { return order("status")["result"].value("/override/spindle"_json_pointer, 0) == 120; });
  EXPECT_NE(order("status").value("text", "").find("override feed 55 %, rapid 25 %, spindle 120 %"),
            std::string::npos);
  // Without a number the job on the machine is meant.
  ASSERT_TRUE(good(job(ApiOp::kHold)));
  until([&] { return order("status")["result"]["phase"] == "hold"; });
  ASSERT_TRUE(good(job(ApiOp::kResume)));
  const std::size_t held = machine_.executed;
  until([&] { return machine_.executed > held + 2; });
  ASSERT_TRUE(good(job(ApiOp::kStop)));
  until([&] { return state(1) == "stopped"; });
  EXPECT_TRUE(good(say("status")));
}

/// What it said last is no news.
TEST_F(SilentMachine, WhatIsShownSaysHowOldItIs) {
  submit_ready(1, 100000);
  ASSERT_TRUE(good(job(ApiOp::kStart, 1)));
  until([&] { return machine_.executed > 3; });
  json shown;
  until([&] { return (shown = job(ApiOp::kShow, 1)).value("silent_seconds", 0.0) > kToldSilent; });
  EXPECT_EQ(shown.value("state", ""), "running");
  const json status = order("status");
  EXPECT_NE(status.value("text", "").find("the controller was last heard"), std::string::npos) << status;
  EXPECT_GT(status["result"].value("silent_seconds", 0.0), kToldSilent);
}

TEST_F(MachineService, AContinuousJogLastsAsLongAsItIsAskedFor) {
  submit_ready(1, 5);
  const json begun = order("jog", "X- F60");
  ASSERT_TRUE(good(begun)) << begun;
  const auto number = begun["order"];
  until([&] { return follow(number, true).contains("in_work") && machine_.x < -0.3; });
  EXPECT_TRUE(has(order("jog", "X1"), "jog is in work"));
  EXPECT_TRUE(has(job(ApiOp::kStart, 1), "jog is in work"));
  // Nobody asks any more: it ends by itself, although no word says so.
  json ended;
  until([&] { return !(ended = follow(number)).contains("in_work"); });
  ASSERT_TRUE(good(ended)) << ended;
  EXPECT_LT(ended["result"]["program"]["X"], -0.3);
  EXPECT_GT(ended["result"]["program"]["X"], -200.0) << "a minute before the end of its travel";
  EXPECT_EQ(say("status")["result"]["state"], "Idle");
}

TEST_F(MachineService, AMotionIsStoppedByItsOrderAndByStop) {
  double to = 150.0;
  for (const std::optional<ApiOp> by :
       {std::optional<ApiOp>(), std::optional(ApiOp::kStop), std::optional(ApiOp::kHold)}) {
    const json begun = order("jog", "X" + std::to_string(to) + " F300");
    to = -to;
    ASSERT_TRUE(good(begun)) << begun;
    const auto number = begun["order"];
    EXPECT_TRUE(good(by ? job(*by) : follow(number, false, true)));
    json ended;
    until([&] { return !(ended = follow(number)).contains("in_work"); });
    EXPECT_TRUE(has(ended, "stopped on request")) << ended;
    EXPECT_EQ(say("status")["result"]["state"], "Idle");
  }
}

/// A machine that was moved, reset or stopped is not called parked.
TEST_F(MachineService, AtAToolChangeWhatIsSaidOfTheMachineIsTrue) {
  EXPECT_TRUE(good(submit_text("G21\nG90\nG94\nG0 X0 Y0 Z50 A0 C0\nT3 M6\nG0 X1\nM2\n")));
  until([&] { return state(1) == "ready"; });
  ASSERT_TRUE(good(job(ApiOp::kStart, 1)));
  until([&] { return state(1) == "tool change"; });
  const auto parked = [&] { return job(ApiOp::kShow, 1).value("parked", ""); };
  EXPECT_EQ(parked(), "parked, spindle and coolant off");
  EXPECT_TRUE(good(say("status")));
  EXPECT_EQ(parked(), "parked, spindle and coolant off");
  const json begun = order("jog", "X150 F300");
  ASSERT_TRUE(good(begun)) << begun;
  EXPECT_NE(parked().find("after `machine jog"), std::string::npos) << parked();
  // The job's own hold ends what moves, too.
  EXPECT_NE(job(ApiOp::kHold, 1).value("text", "").find("told to end"), std::string::npos);
  json ended;
  until([&] { return !(ended = follow(begun["order"])).contains("in_work"); });
  EXPECT_TRUE(has(ended, "stopped on request")) << ended;
  const std::string said = job(ApiOp::kStop, 1).value("text", "");
  EXPECT_EQ(said.find("was parked"), std::string::npos) << said;
  EXPECT_NE(said.find("after `machine jog"), std::string::npos) << said;
}

/// The way back is no part of the program: what is left of that says nothing of it.
TEST_F(MachineService, NobodyKnowsHowLongAWayBackTakes) {
  EXPECT_TRUE(good(submit_text("G21\nG90\nG94\nG0 X0 Y0 Z140 A0 C0\nT3 M6\nG1 X150 F60\nM2\n")));
  until([&] { return state(1) == "ready"; });
  ASSERT_TRUE(good(job(ApiOp::kStart, 1)));
  until([&] { return state(1) == "tool change"; });
  ApiRequest go;
  go.op = ApiOp::kTool;
  go.job = 1;
  go.command = "go";
  go.confirmed = true;
  ASSERT_TRUE(good(ask(go)));
  json shown;
  const auto on_the_way = [&] {
    shown = job(ApiOp::kShow, 1);
    return shown.value("held", "").find("goes back") != std::string::npos;
  };
  until(on_the_way);  // at plunge feed from the top: seconds
  EXPECT_EQ(shown.value("machine_seconds", -1.0), 0.0) << shown;
  EXPECT_EQ(shown.value("remaining_seconds", -1.0), 0.0) << shown;
  until([&] { return !on_the_way() && shown.value("executed", 0) > 4; });
  EXPECT_GT(shown.value("remaining_seconds", 0.0), 0.0) << shown;
  ASSERT_TRUE(good(job(ApiOp::kStop)));
  until([&] { return state(1) == "stopped"; });
}

}  // namespace
}  // namespace tiltfeed
