#include "daemon/service/plan_help.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "daemon/files/durable.h"

namespace tiltfeed::daemon {

namespace {

const std::vector<std::string>& plan_inputs() {
  static const std::vector<std::string> names = {"job.yaml", "part.stl", kForeignProfile};
  return names;
}

}  // namespace

const std::vector<std::string>& plan_outputs() {
  static const std::vector<std::string> names = {"program.nc", "block.map", "path.cls", "report.json"};
  return names;
}

Result<void> name_files(const std::string& folder, const std::vector<int>& files,
                        const std::vector<std::string>& names) {
  const auto failed = [&](const std::string& name) {
    return fail(Code::kIo, folder + "/" + name + ": " + std::strerror(errno));
  };
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string path = folder + "/" + names[i];
    if (::unlink(path.c_str()) != 0 && errno != ENOENT) return failed(names[i]);
    const std::string nameless = "/proc/self/fd/" + std::to_string(files.at(i));
    if (::linkat(AT_FDCWD, nameless.c_str(), AT_FDCWD, path.c_str(), AT_SYMLINK_FOLLOW) != 0)
      return failed(names[i]);
  }
  if (const int synced = sync_folder(folder); synced < 0)
    return fail(Code::kIo, folder + ": cannot be made durable: " + std::strerror(-synced));
  return {};
}

PlanHelper::PlanHelper(const std::string& spool) : folder_(spool + "/shop_plan") { clear(); }

void PlanHelper::clear() const {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

Result<void> PlanHelper::begin(const PlanTaken& order, const std::vector<int>& files) {
  clear();
  if (::mkdir(folder_.c_str(), S_IRWXU) != 0) return fail(Code::kIo, folder_ + ": " + std::strerror(errno));
  if (Result<void> named = name_files(folder_, files, plan_inputs()); !named) return named;
  Result<PlanProcess> started = start_foreign_plan(folder_);
  if (!started) return tl::unexpected<Error>(started.error());
  process_ = std::move(*started);
  order_ = order;
  state_ = HelpState::kPlanning;
  note_.clear();
  return {};
}

void PlanHelper::give_back() {
  if (!order_ || state_ != HelpState::kPlanning) return;
  stop_plan(process_);
  state_ = HelpState::kGivenBack;
}

bool PlanHelper::tick() {
  if (!order_ || state_ != HelpState::kPlanning) return false;
  const std::optional<Result<void>> ended = check_plan(process_);
  if (!ended) return false;
  state_ = *ended ? HelpState::kDone : HelpState::kFailed;
  if (!*ended) note_ = ended->error().message;
  return true;
}

void PlanHelper::settle(const std::string& id) {
  if (!order_ || order_->id != id) return;
  stop_plan(process_);
  order_.reset();
  clear();
}

std::optional<PlanHelp> PlanHelper::told() const {
  if (!order_) return std::nullopt;
  PlanHelp help{*order_, state_, 0, "", note_, {}};
  if (const auto at = stage_of(folder_)) help.percent = at->percent, help.stage = at->stage;
  for (std::size_t i = 0; i < kPlanOutputs; ++i) help.files[i] = folder_ + "/" + plan_outputs()[i];
  return help;
}

std::string PlanHelper::text() const {
  return order_ && state_ == HelpState::kPlanning ? "planning " + order_->name + " for " + order_->asker : "";
}

}  // namespace tiltfeed::daemon
