#pragma once
// The job service in the test's own process: opened, asked, turned and left as its daemon does it.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "daemon/service/job_service.h"
#include "tests/peers/spool_add.h"
#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;

class ServedJobs {
 protected:
  /// `name`: of the folder that holds the spool. `patience`: so long only a hang takes.
  ServedJobs(const std::string& name, std::chrono::seconds patience) : patience_(patience), folder_(name) {}
  ~ServedJobs() = default;

  ServiceConfig config(const MachineModel& machine, const std::string& link) const {
    ServiceConfig config;
    config.machine.model = machine;
    config.link = link;
    config.spool = folder_.path + "/spool";
    config.retention = retention_;
    config.watch = watch_;
    return config;
  }
  /// The system gives a pseudo-terminal's number to the next one as soon as its machine is gone: a service of
  /// another test may still claim it, until it has left.
  void open(const MachineModel& machine, const std::string& link) {
    const auto end = std::chrono::steady_clock::now() + patience_;
    for (;; std::this_thread::sleep_for(std::chrono::milliseconds(20))) {
      auto jobs = JobService::open(config(machine, link), [] {});
      const bool claimed = !jobs && jobs.error().message.find(" serves already") != std::string::npos;
      if (claimed && std::chrono::steady_clock::now() < end) continue;
      ASSERT_TRUE(jobs) << jobs.error().message;
      jobs_ = std::make_unique<JobService>(std::move(*jobs));
      return;
    }
  }
  /// As at SIGTERM.
  void leave() {
    jobs_->leave();
    until([&] { return !jobs_->busy(); });
    jobs_.reset();
  }
  nlohmann::json ask(const ApiRequest& request, const std::vector<int>& files = {}) {
    return nlohmann::json::parse(answer_of(*jobs_, request, 1000, files));
  }
  nlohmann::json ask(ApiOp op, std::uint64_t job = 0, std::optional<std::uint64_t> from = {},
                     bool confirmed = false) {
    ApiRequest request;
    request.op = op;
    request.job = job;
    request.from = from;
    request.confirmed = confirmed;
    return ask(request);
  }
  /// A program of this text.
  nlohmann::json submit_text(const std::string& text) {
    const int fd = ::open(folder_.write("program.nc", text).c_str(), O_RDONLY);
    ApiRequest request;
    request.op = ApiOp::kSubmit;
    request.program = true;
    nlohmann::json taken = ask(request, {fd});
    ::close(fd);
    return taken;
  }
  /// A program of so many moves, each of 60 / `per_minute` s, then `more`; it is ready.
  std::uint64_t submit_moves(int count, int per_minute, const std::string& more = "") {
    std::string text = "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nG93\n";
    for (int i = 0; i < count; ++i)
      text += "G1 X" + std::to_string(i % 2) + " Y1 Z50 A0 C0 F" + std::to_string(per_minute) + "\n";
    const std::uint64_t job = submit_text(text + more + "M2\n").at("job");
    until([&] { return state(job) == "ready"; });
    return job;
  }
  std::string field(std::uint64_t job, const char* key) { return ask(ApiOp::kShow, job).value(key, ""); }
  std::string state(std::uint64_t job) { return field(job, "state"); }
  static bool good(const nlohmann::json& answer) { return answer.value("ok", false); }
  template <class Condition>
  void until(Condition condition) {
    const auto end = std::chrono::steady_clock::now() + patience_;
    while (!condition()) {
      ASSERT_LT(std::chrono::steady_clock::now(), end) << ask(ApiOp::kList).dump(1);
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      jobs_->tick();
    }
  }

  const std::chrono::seconds patience_;
  const Folder folder_;
  Retention retention_;
  std::string watch_;  ///< folder; empty: none
  std::unique_ptr<JobService> jobs_;
};

}  // namespace tiltfeed
