#include "desk/api/run_api.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "config/job.h"
#include "desk/api/replies.h"

namespace tiltfeed::desk {
namespace {

using nlohmann::json;

constexpr char kRoot[] = "/api/v1/";
constexpr std::size_t kMaxWords = 200;

/// The body as one object of plain values; nothing where it is anything else.
std::optional<json> object_of(const std::string& body) {
  const json parsed = json::parse(body.empty() ? "{}" : body, nullptr, false);
  if (!parsed.is_object()) return std::nullopt;
  for (const auto& [key, value] : parsed.items())
    if (value.is_structured()) return std::nullopt;
  return parsed;
}

std::string request_of(const char* op, const json& more) {
  json all = {{"v", 1}, {"op", op}};
  all.update(more);
  return all.dump(-1, ' ', true, json::error_handler_t::replace);
}

}  // namespace

const std::vector<RunApi::Route>& RunApi::routes() {
  static const std::vector<Route> all = {
      {"GET", "run", &RunApi::run},
      {"GET", "run/jobs", &RunApi::jobs},
      {"GET", "run/part", &RunApi::part},
      {"GET", "run/path", &RunApi::path},
      {"GET", "run/mesh", &RunApi::mesh},
      {"POST", "run/hold", &RunApi::hold},
      {"POST", "run/resume", &RunApi::plain, true, "resume", {"job", "from", "confirmed"}},
      {"POST", "run/stop", &RunApi::plain, true, "stop", {"job"}},
      {"POST", "run/start", &RunApi::plain, true, "start", {"job", "queue"}},
      {"POST", "run/tool", &RunApi::plain, true, "tool", {"job", "command", "words", "confirmed"}},
      {"POST", "run/remove", &RunApi::plain, true, "remove", {"job"}},
      {"POST", "run/reset", &RunApi::plain, true, "reset", {"confirmed"}},
      {"POST", "run/origin", &RunApi::plain, false, "show", {"job", "block"}},
      {"POST", "run/machine", &RunApi::machine, true},
      {"POST", "run/jog", &RunApi::jog, true},
      {"POST", "run/jog/beat", &RunApi::jog_beat, true},
      {"POST", "run/jog/stop", &RunApi::jog_stop, true},
      {"POST", "run/submit", &RunApi::submit, true, nullptr, {}, true},
      {"PUT", "run/program", &RunApi::program, true, nullptr, {}, true, true},
      {"GET", "seat", &RunApi::seat},
      {"POST", "seat/ask", &RunApi::ask_seat},
      {"POST", "seat/give", &RunApi::give_seat},
      {"POST", "seat/keep", &RunApi::keep_seat},
      {"POST", "seat/beat", &RunApi::beat_seat},
  };
  return all;
}

RunApi::RunApi(const RunOptions& options, RunCalls calls)
    : machine_(options.machine),
      folder_(options.folder),
      calls_(std::move(calls)),
      link_(options.socket),
      watch_(link_, {calls_.tell, [this](std::uint64_t job,
                                         const std::string& folder) { return placing_of(job, folder); }}),
      scene_(options.tiltfeed, options.self, options.folder,
             [this] { watch_.note_scene(scene_.describe()); }) {
  watch_.turned = [this] {
    if (watch_.job() == 0) ask_status();
  };
}

Reply RunApi::later_reply() {
  Reply reply;
  reply.later = true;
  return reply;
}

Reply RunApi::reply_of(const Result<std::string>& answer) {
  if (answer) return text_reply(*answer);
  return refusal(answer.error().code == Code::kUsage ? 409 : 503, answer.error().message);
}

const RunApi::Route* RunApi::route_of(const std::string& method, const std::string& path) {
  const auto found = std::find_if(routes().begin(), routes().end(), [&](const Route& route) {
    return method == route.method && path == kRoot + std::string(route.path);
  });
  return found == routes().end() ? nullptr : &*found;
}

bool RunApi::is_route(const std::string& method, const std::string& path) {
  return route_of(method, path) != nullptr;
}

bool RunApi::is_file(const Request& request) {
  const Route* route = route_of(request.method, request.path);
  return route && route->file;
}

bool RunApi::is_for_programs(const Request& request) {
  const Route* route = route_of(request.method, request.path);
  return route && (route->by_token || request.method == "GET");
}

Reply RunApi::answer(const Request& request, std::uint64_t session, bool program) {
  const Route* route = route_of(request.method, request.path);
  if (!route) return refusal(404, "there is no such request");
  if (!link_.is_named() && std::string_view(route->path).starts_with("run/"))
    return refusal(409, "this desk has no machine: start it with --service SOCKET, beside tiltfeed serve");
  if (route->seat && !program && !seat_.has(session))
    return refusal(409, seat_.owner() == 0 ? "orders need the seat: take it first"
                                           : calls_.name(seat_.owner()) + " has the seat; ask for it");
  return (this->*route->answer)(request, session);
}

/// What of the body the service is told, as it stands.
Reply RunApi::plain(const Request& request, std::uint64_t) {
  const std::optional<json> body = object_of(request.body);
  if (!body) return refusal(400, "expected one JSON object of plain values");
  for (const Route& route : routes()) {
    if (!route.op || request.path != kRoot + std::string(route.path)) continue;
    json more = json::object();
    for (const auto& [key, value] : body->items()) {
      if (std::find(route.keys.begin(), route.keys.end(), key) == route.keys.end())
        return refusal(400, "'" + key.substr(0, kMaxWords) + "' is not expected here");
      more[key] = value;
    }
    const std::string asked = request_of(route.op, more);
    // Our own question to the machine must not be what refuses a start.
    if (!order_ || order_->ticket != 0 || route.op == std::string_view("show") ||
        route.op == std::string_view("stop"))
      return pass_on(request, asked);
    after_order_.emplace_back([this, ticket = request.ticket, asked] {
      link_.ask(asked, [this, ticket](const Result<std::string>& answer) {
        calls_.finish(ticket, reply_of(answer));
      });
    });
    return later_reply();
  }
  return refusal(404, "there is no such request");
}

Reply RunApi::pass_on(const Request& request, const std::string& asked, const std::vector<int>& files) {
  link_.ask(
      asked,
      [this, ticket = request.ticket](const Result<std::string>& answer) {
        calls_.finish(ticket, reply_of(answer));
      },
      files);
  return later_reply();
}

Reply RunApi::run(const Request&, std::uint64_t) { return text_reply(watch_.describe()); }

Reply RunApi::jobs(const Request&, std::uint64_t) { return text_reply(watch_.jobs()); }

/// The run is held; where there is none, the command that moves the machine is ended.
Reply RunApi::hold(const Request& request, std::uint64_t) {
  link_.ask(request_of("hold", json::object()), [this,
                                                 ticket = request.ticket](const Result<std::string>& held) {
    if (held || held.error().code != Code::kUsage || !order_ || order_->number == 0)
      return calls_.finish(ticket, reply_of(held));
    link_.ask(request_of("machine", {{"order", order_->number}, {"stop", true}}),
              [this, ticket](const Result<std::string>& ended) { calls_.finish(ticket, reply_of(ended)); });
  });
  return later_reply();
}

Reply RunApi::submit(const Request& request, std::uint64_t) {
  std::optional<PlannedProgram> planned = calls_.planned();
  if (!planned) return refusal(409, "no program is planned on this desk; plan one first");
  // The next plan replaces its part.
  const std::string part = folder_ + "/submitted.stl";
  std::error_code error;
  std::filesystem::create_directory(folder_, error);
  std::filesystem::remove(part, error);
  std::filesystem::create_hard_link(planned->scene.part, part, error);
  planned->scene.part = error ? "" : part;
  const int file = ::open(planned->file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (file < 0) return refusal(507, std::string("the program cannot be read: ") + std::strerror(errno));
  link_.ask(request_of("submit", {{"name", planned->name.substr(0, kMaxWords)}, {"program", true}}),
            [this, ticket = request.ticket, with = *planned](const Result<std::string>& answer) {
              if (answer) {
                const json said = json::parse(*answer, nullptr, false);
                submitted_ = said.value("job", std::uint64_t{0});
                submitted_with_ = with;
              }
              calls_.finish(ticket, reply_of(answer));
            },
            {file});
  ::close(file);  // the service has its own
  return later_reply();
}

/// A program from elsewhere, as a CAM system's post writes it.
Reply RunApi::program(const Request& request, std::uint64_t) {
  if (request.file.empty() || request.length.value_or(0) == 0)
    return refusal(400, "the file is empty; expected the text of a program");
  const int file = ::open(request.file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (file < 0) return refusal(507, std::string("the program cannot be read: ") + std::strerror(errno));
  ::unlink(request.file.c_str());  // the descriptor keeps it until the service has copied it
  const Reply later = pass_on(
      request, request_of("submit", {{"name", shown_name(request.name, "program")}, {"program", true}}),
      {file});
  ::close(file);
  return later;
}

/// The part of the job on the machine, as it was handed to the service.
Reply RunApi::part(const Request&, std::uint64_t) {
  Reply reply;
  if (watch_.folder().empty()) return refusal(409, "no job is on the machine");
  reply.type = "application/octet-stream";
  reply.file = watch_.folder() + "/part.stl";
  return reply;
}

Reply RunApi::path(const Request&, std::uint64_t) { return scene_.path(); }

Reply RunApi::mesh(const Request&, std::uint64_t) { return scene_.mesh(); }

/// Its scene begins, too.
std::optional<Placing> RunApi::placing_of(std::uint64_t job, const std::string& folder) {
  SceneInput scene;
  std::optional<Placing> placing;
  if (job == submitted_) {
    scene = submitted_with_.scene;
    placing = submitted_with_.placing;
  } else if (!machine_.empty()) {
    scene.machine = machine_;
    const std::string part = folder + "/part.stl";
    const config::JobFiles files{.stl = part, .machine = machine_, .closed = true};
    if (const auto loaded = config::load_operations(folder + "/job.yaml", files)) {
      placing = placing_of_operations(*loaded);
      scene = scene_of(*loaded, part, machine_);
    }
  }
  scene.job = job;
  scene.program = folder + "/program.nc";
  scene_.begin(std::move(scene));
  return placing;
}

std::vector<int> RunApi::descriptors() const {
  std::vector<int> all = link_.descriptors();
  if (scene_.descriptor() >= 0) all.push_back(scene_.descriptor());
  return all;
}

void RunApi::hear(int descriptor) {
  if (descriptor == scene_.descriptor())
    scene_.hear();
  else
    (void)link_.hear(descriptor);
}

}  // namespace tiltfeed::desk
