#include "desk/api/run_scene.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "config/description.h"
#include "desk/api/replies.h"
#include "desk/http/access_check.h"
#include "desk/work/progress_text.h"

namespace tiltfeed::desk {
namespace {

using nlohmann::json;

// Of the drawn path from the program's; what is nearer cannot be seen.
constexpr const char* kDrawnTolerance = "0.02";     // mm
constexpr const char* kDrawnAxisTolerance = "0.5";  // degrees

json tool_json(const std::vector<ToolOutline>& tool) {
  json pieces = json::array();
  for (const ToolOutline& piece : tool) pieces.push_back({{"part", piece.part}, {"outline", piece.points}});
  return pieces;
}

}  // namespace

SceneInput scene_of(const std::vector<config::Job>& jobs, const std::string& part,
                    const std::string& machine) {
  const config::Job& job = jobs.front();
  SceneInput scene;
  scene.part = part;
  scene.machine = machine;
  scene.unit = config::exact_text(job.stl_unit_mm);
  scene.bodies = job.bodies;
  scene.tool = tool_outline(job.plan.cutter);
  for (const config::Job& one : jobs)
    if (!one.operation.name.empty())
      scene.operations.emplace_back(one.operation.name, tool_outline(one.plan.cutter));
  return scene;
}

Placing placing_of_operations(const std::vector<config::Job>& jobs) {
  Placing placing{jobs.front().machine.model, jobs.front().setup, {}};
  for (const config::Job& job : jobs) placing.operations[job.operation.name] = job.setup;
  return placing;
}

RunScene::RunScene(std::string tiltfeed, std::string self, std::string folder, std::function<void()> told)
    : tiltfeed_(std::move(tiltfeed)),
      self_(std::move(self)),
      folder_(std::move(folder)),
      told_(std::move(told)) {}

void RunScene::begin(SceneInput input) {
  child_.reset();
  in_work_ = nullptr;
  input_ = std::move(input);
  error_.clear();
  path_.state = part_.state = State::kNone;
  std::error_code error;
  std::filesystem::create_directory(folder_, error);
  if (error) return refuse(path_, folder_ + ": " + error.message());
  if (!input_.part.empty()) {
    part_.state = State::kWaiting;
    part_.words = {self_, "--view-part", input_.part, "--unit", input_.unit, "--into", folder_};
    for (const std::string& body : input_.bodies) part_.words.push_back("--body=" + body);
  }
  if (input_.machine.empty()) {
    refuse(path_, "the desk does not know the machine's profile");
  } else {
    path_.state = State::kWaiting;
    path_.words = {tiltfeed_,       "unpost",           input_.program,        "--machine",
                   input_.machine,  "--drawing",        folder_ + "/path.f32", "--tolerance",
                   kDrawnTolerance, "--axis-tolerance", kDrawnAxisTolerance};
  }
  start_next();
}

void RunScene::start_next() {
  for (Piece* piece : {&path_, &part_}) {
    if (child_ || piece->state != State::kWaiting) continue;
    Result<ChildProcess> child = ChildProcess::start(piece->words);
    if (!child) {
      refuse(*piece, child.error().message);
      continue;
    }
    child_.emplace(std::move(*child));
    in_work_ = piece;
  }
  told_();
}

void RunScene::refuse(Piece& piece, std::string why) {
  piece.state = State::kRefused;
  // Advice about options is for a command line.
  if (const std::size_t advice = why.find("; "); advice != why.npos && why.find("--", advice) != why.npos)
    why.erase(advice);
  if (error_.empty()) error_ = std::move(why);
}

void RunScene::hear() {
  if (!child_ || !child_->listen()) return;
  const ChildEnd end = child_->end();
  child_.reset();
  if (end.status == 0)
    in_work_->state = State::kReady;
  else
    refuse(*in_work_, last_words(end.text, in_work_ == &path_ ? "tiltfeed: " : "tiltfeed-desk: ",
                                 std::filesystem::path(input_.program).parent_path().string() + "/"));
  start_next();
}

std::string RunScene::describe() const {
  if (input_.job == 0) return "null";
  constexpr const char* kNames[] = {"none", "working", "ready", "refused"};
  json about{{"job", input_.job}};
  for (const Piece* piece : {&path_, &part_}) about[piece->name] = kNames[static_cast<int>(piece->state)];
  if (!error_.empty()) about["error"] = error_;
  about["tool"] = tool_json(input_.tool);
  about["operations"] = json::array();
  for (const auto& [name, tool] : input_.operations)
    about["operations"].push_back({{"name", name}, {"tool", tool_json(tool)}});
  return about.dump(-1, ' ', true, json::error_handler_t::replace);
}

Reply RunScene::file(const Piece& piece, const char* name) const {
  if (piece.state != State::kReady)
    return refusal(409, std::string("there is no ") + piece.name + " of a run to draw");
  Reply reply;
  reply.type = kOctets;
  reply.file = folder_ + "/" + name;
  return reply;
}

Reply RunScene::path() const { return file(path_, "path.f32"); }

Reply RunScene::mesh() const { return file(part_, "mesh.f32"); }

}  // namespace tiltfeed::desk
