#include "desk/api/desk.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "config/job.h"
#include "config/yaml_tree.h"
#include "desk/api/page_reply.h"
#include "desk/api/replies.h"
#include "desk/users/password_hash.h"
#include "kinematics/basics/tolerance_budget.h"
#include "pathgen/mesh/stl_facets.h"

namespace tiltfeed::desk {
namespace {

using nlohmann::json;

constexpr std::uint64_t kSmallBody = 4096, kEditsBody = 64 * 1024;
constexpr char kShopRoutes[] = "/api/v1/shop/";
constexpr char kPart[] = "part.stl";  // of a part without a name

/// As `tiltfeed verify` calls the folder of one of several operations.
std::string folder_of(const config::OperationName& operation) {
  return operation.count == 1 ? "" : std::to_string(operation.number) + "-" + operation.name;
}

}  // namespace

struct Desk::Route {
  const char* method;
  const char* path;
  Reply (Desk::*answer)(const Request&);
  std::uint64_t most = 0;
  bool file = false;
};

const std::vector<Desk::Route>& Desk::routes() {
  static const std::vector<Route> all = {
      {"POST", "/api/v1/session", &Desk::sign_in, kSmallBody},
      {"GET", "/api/v1/session", &Desk::session},
      {"DELETE", "/api/v1/session", &Desk::sign_out},
      {"GET", "/api/v1/state", &Desk::state},
      {"GET", "/api/v1/events", &Desk::events},
      {"PUT", "/api/v1/part", &Desk::put_part, pathgen::kMaxStlBytes, true},
      {"POST", "/api/v1/part/unit", &Desk::set_unit, kSmallBody},
      {"GET", "/api/v1/part/mesh", &Desk::mesh},
      {"GET", "/api/v1/part/edges", &Desk::edges},
      {"GET", "/api/v1/part/model", &Desk::part_model},
      {"GET", "/api/v1/part/faces", &Desk::part_faces},
      {"GET", "/api/v1/job", &Desk::job_text},
      {"GET", "/api/v1/job/text", &Desk::job_file},
      {"PUT", "/api/v1/job", &Desk::put_job, config::kMaxConfigBytes},
      {"POST", "/api/v1/job/save", &Desk::save_job, kSmallBody},
      {"POST", "/api/v1/part/sample", &Desk::make_sample, kSmallBody},
      {"GET", "/api/v1/machines", &Desk::machines},
      {"POST", "/api/v1/job/new", &Desk::new_job, kSmallBody},
      {"POST", "/api/v1/job/machine", &Desk::choose_machine, kSmallBody},
      {"GET", "/api/v1/machine/view", &Desk::machine_view},
      {"POST", "/api/v1/job/edit", &Desk::edit_job, kEditsBody},
      {"POST", "/api/v1/job/operation", &Desk::edit_operations, kSmallBody},
      {"GET", "/api/v1/schema", &Desk::schema},
      {"POST", "/api/v1/suggest", &Desk::start_suggest, kSmallBody},
      {"DELETE", "/api/v1/suggest", &Desk::cancel_suggest},
      {"POST", "/api/v1/reach", &Desk::ask_reach, kEditsBody},
      {"GET", "/api/v1/reach/map", &Desk::reach_map},
      {"POST", "/api/v1/fit", &Desk::ask_fit, kEditsBody},
      {"POST", "/api/v1/plan", &Desk::start_plan, kSmallBody},
      {"DELETE", "/api/v1/plan", &Desk::cancel_plan},
      {"GET", "/api/v1/plan/program", &Desk::program},
      {"GET", "/api/v1/plan/path", &Desk::path},
      {"GET", "/api/v1/plan/map", &Desk::map},
      {"GET", "/api/v1/plan/report", &Desk::report},
      {"POST", "/api/v1/cut", &Desk::start_cut, kSmallBody},
      {"DELETE", "/api/v1/cut", &Desk::cancel_cut},
      {"GET", "/api/v1/cut/view", &Desk::cut_view},
      {"GET", "/api/v1/cut/before", &Desk::cut_before},
      {"GET", "/api/v1/cut/page", &Desk::cut_page},
      {"GET", "/api/v1/cut/report", &Desk::cut_report},
      {"GET", "/api/v1/shop", &Desk::shop},
      {"GET", "/api/v1/metrics", &Desk::metrics},
      {"GET", kMetrics, &Desk::metrics},
      {"POST", "/api/v1/shop/release", &Desk::release_job, kSmallBody},
      {"POST", "/api/v1/shop/withdraw", &Desk::withdraw_job, kSmallBody},
      {"POST", "/api/v1/shop/raise", &Desk::raise_shop, kSmallBody},
  };
  return all;
}

Desk::Desk(const DeskOptions& options, Teller tell, std::function<void(std::uint64_t, const Reply&)> finish)
    : options_(options),
      finish_(std::move(finish)),
      tell_(std::move(tell)),
      part_(options.self, options.folder, tell_),
      job_(options.folder),
      plan_(options.tiltfeed, options.folder, tell_),
      cut_(options.maker, options.folder, tell_),
      suggest_(options.tiltfeed, options.folder, tell_),
      reach_(options.self, options.folder, tell_),
      machine_(options.maker, options.folder, tell_),
      run_({options.service, options.machine, options.tiltfeed, options.self, options.folder + "/run"},
           {tell_, finish_, [this] { return planned(); },
            [this](std::uint64_t number) {
              const Session* session = sessions_.number(number);
              const std::string browser = "browser " + std::to_string(number);
              return session && !session->user.empty() ? session->user + ", " + browser : browser;
            }}),
      shop_({options.shop, options.tiltfeed, options.folder}, tell_, finish_),
      metrics_({options.config, options.tiltfeed}, finish_) {}

void Desk::set_port(std::uint16_t port) {
  port_ = port;
  rules_.hosts.clear();
  for (const char* name : {"127.0.0.1", "localhost"})
    rules_.hosts.push_back(std::string(name) + ":" + std::to_string(port));
  if (!options_.names.empty()) rules_.hosts = options_.names;
  rules_.scheme = options_.https ? "https://" : "http://";
  rules_.users = !options_.users.empty();
  if (rules_.users) nobody_ = hash_password("nobody has this one").value_or("");
}

Result<void> Desk::copy_part(const std::string& path, const std::string& unit) {
  const std::string copy = options_.folder + "/opened.stl";
  std::error_code error;
  std::filesystem::copy_file(path, copy, error);
  if (error) return fail(Code::kIo, path + ": " + error.message());
  return part_.take(copy, shown_name(path, kPart), unit);
}

Result<void> Desk::open(const std::string& path) {
  const std::string kind = std::filesystem::path(path).extension().string();
  if (kind != ".yaml" && kind != ".yml") {
    const Result<void> copied = copy_part(path, "mm");
    if (copied) part_folder_ = std::filesystem::absolute(path).parent_path().string();
    return copied;
  }
  if (const Result<void> opened = job_.open(path); !opened) return opened;
  machine_.start(job_.file(), job_.machine(), job_.id());
  part_.choose_for_next(chosen_part());
  return copy_part(job_.stl(), job_.unit());
}

Result<std::string> Desk::new_address() {
  if (rules_.users) return rules_.scheme + rules_.hosts.front() + "/";
  const Result<std::string> token = sessions_.new_token();
  if (!token) return token;
  return rules_.scheme + rules_.hosts.front() + "/#token=" + *token;
}

std::string Desk::cookie_of(const Request& request) const {
  return std::string(cookie_value(request.cookie, cookie_name()));
}

/// Cookies take no notice of ports, so the name carries it.
std::string Desk::cookie_name() const {
  return (options_.https ? "__Host-tiltfeed-" : "tiltfeed-") + std::to_string(port_);
}

const Desk::Route* Desk::route_of(const Request& request) const {
  for (const Route& route : routes())
    if (request.path == route.path && request.method == route.method) return &route;
  return nullptr;
}

/// The program whose token the request states; nothing: it states none. The file is read each time: a token
/// that was taken out is out. Errors: kUsage: it is not known; kInput, kIo: the file.
Result<std::optional<ProgramToken>> Desk::program_of(const Request& request) const {
  constexpr std::string_view kScheme = "Bearer ";
  const std::string& stated = request.authorization;
  if (stated.empty()) return std::nullopt;
  if (options_.tokens.empty())
    return fail(Code::kUsage, "this desk takes no tokens; its access file names none");
  if (stated.rfind(kScheme, 0) != 0)
    return fail(Code::kUsage, "expected the header Authorization: Bearer TOKEN");
  const Result<std::vector<ProgramToken>> known = load_tokens(options_.tokens);
  if (!known) return tl::unexpected<Error>(known.error());
  auto found = find_token(*known, stated.substr(kScheme.size()));
  if (!found) return fail(Code::kUsage, "this token is not known");
  return found;
}

std::optional<Reply> Desk::admit(const Request& request, BodyRule& rule) {
  const Session* session = sessions_.find(cookie_of(request));
  Sender sender{session ? session->csrf : "", session && session->operates};
  const Result<std::optional<ProgramToken>> program = program_of(request);
  if (!program && program.error().code != Code::kUsage)  // who asks is not known: nothing of where files are
    return refusal(500, "the file of tokens cannot be used; tiltfeed desk token list says why");
  if (program && *program) sender = {"", (*program)->submits, true};
  if (!program) sender = {"", true, true};  // what is wrong besides its token is told first
  if (auto reply = refused(request, rules_, sender)) return reply;
  if (!program) return refusal(401, program.error().message);
  if (request.path.rfind(kApi, 0) != 0) return std::nullopt;
  const Route* route = route_of(request);
  if (!route && RunApi::is_route(request.method, request.path)) {
    if (sender.program && !RunApi::is_for_programs(request))
      return refusal(403, "a token gives no orders to the machine; an operator with the seat does");
    const bool file = RunApi::is_file(request);
    rule = {file ? pathgen::kMaxStlBytes : kSmallBody, file};
    return std::nullopt;
  }
  if (!route)
    return refusal(404, "the API has no " + request.method + " at this path; desk/API.md lists what it has");
  if (sender.program && request.method != "GET" && request.path.rfind(kShopRoutes, 0) == 0)
    return refusal(403, "a token gives no orders to the shop's queue; a user who operates does");
  rule = {route->most, route->file};
  return std::nullopt;
}

Reply Desk::answer(const Request& request) {
  if (RunApi::is_route(request.method, request.path)) {
    const Session* session = sessions_.find(cookie_of(request));
    // admit() has seen the token.
    return run_.answer(request, session ? session->number : 0, !request.authorization.empty());
  }
  const Route* route = route_of(request);
  return route ? (this->*route->answer)(request) : page_reply(request);
}

Reply Desk::state(const Request&) {
  return text_reply("{\"api\": 1, \"version\": \"" + options_.version + "\", \"part\": " + part_.describe() +
                    ", \"job\": " + job_.describe() + ", \"plan\": " + plan_.describe() +
                    ", \"cut\": " + cut_.describe() + ", \"suggest\": " + suggest_.describe() +
                    ", \"reach\": " + reach_.describe() + ", \"machine\": " + machine_.describe() +
                    ", \"run\": " + run_.describe_run() + ", \"seat\": " + run_.describe_seat() +
                    ", \"shop\": " + shop_.describe() + "}");
}

Reply Desk::events(const Request&) {
  Reply reply;
  reply.events = true;
  return reply;
}

Reply Desk::put_part(const Request& request) {
  if (request.file.empty() || request.length.value_or(0) == 0)
    return refusal(400, "the file is empty; expected an STL, OBJ, PLY, 3MF, STEP or IGES file");
  const std::string stated = request.unit.empty() ? "mm" : request.unit;
  const std::string unit = job_.is_open() ? job_.unit() : stated;
  if (const Result<void> taken = part_.take(request.file, shown_name(request.name, kPart), unit); !taken)
    return refusal(taken.error().code == Code::kUsage ? 400 : 507, taken.error().message);
  part_folder_.clear();
  return text_reply(part_.describe(), 202);
}

Reply Desk::set_unit(const Request& request) {
  const auto unit = text_in(request.body, "unit");
  if (!unit) return refusal(400, "expected {\"unit\": \"mm\"}, inch or m");
  if (job_.is_open()) return refusal(409, "the job says the unit: change its part.unit");
  if (const Result<void> set = part_.set_unit(*unit); !set) return refusal(400, set.error().message);
  return text_reply(part_.describe(), 202);
}

Reply Desk::metrics(const Request& request) { return metrics_.ask(request.ticket); }

Reply Desk::mesh(const Request&) { return part_.mesh(); }

Reply Desk::edges(const Request&) { return part_.edges(); }

Reply Desk::part_model(const Request&) { return part_.model(); }

Reply Desk::part_faces(const Request&) { return part_.faces(); }

/// Facets as the planner of the first operation has them.
PartChoice Desk::chosen_part() const {
  const config::Job& job = job_.job();
  const double deviation =
      job.tessellation > 0.0 ? job.tessellation : ToleranceBudget::tessellation(job.plan.tolerance);
  return {job.bodies, job.avoid_faces, deviation};
}

Reply Desk::job_text(const Request&) {
  if (!job_.is_open()) return refusal(409, "no job is open; start tiltfeed desk with a job file");
  const json text = {{"id", job_.id()}, {"text", job_.text()}};
  return text_reply(text.dump(-1, ' ', true, json::error_handler_t::replace));
}

Reply Desk::put_job(const Request& request) {
  if (const Result<void> set = job_.set_text(request.body); !set) return refused_by(set.error());
  return job_changed();
}

Reply Desk::job_changed() {
  tell_("job", job_.describe());
  if (job_.is_right()) machine_.start(job_.file(), job_.machine(), job_.id());
  // The part is drawn in the unit that the job says it is in.
  if (job_.is_right() && part_.id() != 0) {
    const bool other_unit = part_.unit() != job_.unit();
    if (other_unit) part_.choose_for_next(chosen_part());
    if (other_unit)
      (void)part_.set_unit(job_.unit());
    else
      part_.choose(chosen_part());
  }
  return text_reply(job_.describe());
}

Reply Desk::save_job(const Request&) {
  if (const Result<void> saved = job_.save(); !saved) return refused_by(saved.error());
  tell_("job", job_.describe());
  return text_reply(job_.describe());
}

Reply Desk::start_plan(const Request& request) {
  const std::string operation = text_in(request.body, "operation").value_or("");
  const std::string optimise = text_in(request.body, "optimise").value_or("");
  if (!optimise.empty() && optimise != "time" && optimise != "feed")
    return refusal(400, "optimise: expected \"time\" or \"feed\"");
  if (!job_.is_right())
    return refusal(409, job_.is_open() ? "the job has errors; mend them first" : "no job is open");
  if (part_.stl().empty()) return refusal(409, "there is no part that has been read");
  PlanInput input{job_.file(), part_.stl(), job_.machine(), job_.id(), part_.id(), operation, optimise, {}};
  for (const config::Job& job : job_.operations())
    if (operation.empty() || job.operation.name == operation)
      input.operations.push_back({job.operation.name, folder_of(job.operation)});
  if (input.operations.empty()) return refusal(409, "there is no operation of this name");
  if (const Result<void> begun = plan_.start(input); !begun) return refused_by(begun.error());
  return text_reply(plan_.describe(), 202);
}

Reply Desk::cancel_plan(const Request&) {
  if (const Result<void> cancelled = plan_.cancel(); !cancelled) return refused_by(cancelled.error());
  return text_reply(plan_.describe(), 202);
}

Reply Desk::program(const Request&) { return plan_.program(); }

Reply Desk::path(const Request&) { return plan_.drawing(); }

Reply Desk::map(const Request&) { return plan_.map(); }

Reply Desk::report(const Request&) { return plan_.report(); }

std::vector<int> Desk::descriptors() const {
  std::vector<int> all;
  for (const int fd : {part_.descriptor(), plan_.descriptor(), cut_.descriptor(), suggest_.descriptor(),
                       reach_.descriptor(), machine_.descriptor(), metrics_.descriptor()})
    if (fd >= 0) all.push_back(fd);
  for (const int fd : run_.descriptors()) all.push_back(fd);
  for (const int fd : shop_.descriptors()) all.push_back(fd);
  if (passwords_.descriptor() >= 0) all.push_back(passwords_.descriptor());
  return all;
}

void Desk::hear(int descriptor) {
  if (descriptor == part_.descriptor())
    part_.hear();
  else if (descriptor == plan_.descriptor())
    plan_.hear();
  else if (descriptor == cut_.descriptor())
    cut_.hear();
  else if (descriptor == suggest_.descriptor())
    suggest_.hear();
  else if (descriptor == reach_.descriptor())
    reach_.hear();
  else if (descriptor == machine_.descriptor())
    machine_.hear();
  else if (descriptor == metrics_.descriptor())
    metrics_.hear();
  else if (descriptor == passwords_.descriptor())
    passwords_.hear(std::chrono::steady_clock::now());
  else if (!shop_.hear(descriptor, std::chrono::steady_clock::now()))
    run_.hear(descriptor);
}

int Desk::patience_ms() const {
  const auto now = std::chrono::steady_clock::now();
  const int shop = shop_.patience_ms(now), own = run_.patience_ms(now);
  const int run = own < 0 || (shop >= 0 && shop < own) ? shop : own;
  if (!plan_.is_working() && !suggest_.is_working() && !cut_.is_working()) return run;
  return run < 0 ? PlanWork::kLookMs : std::min(run, PlanWork::kLookMs);
}

void Desk::look() {
  plan_.look();
  suggest_.look();
  cut_.look();
  run_.look(std::chrono::steady_clock::now());
  shop_.look(std::chrono::steady_clock::now());
}

std::optional<PlannedProgram> Desk::planned() const {
  const Reply program = plan_.program();
  if (program.file.empty()) return std::nullopt;
  const json job = json::parse(job_.describe(), nullptr, false);
  const std::string file = job.is_object() ? job.value("name", "program") : "program";
  PlannedProgram planned{program.file, std::filesystem::path(file).stem().string(), std::nullopt, {}};
  const CutInput with = plan_.cut_input();
  const auto loaded = config::load_operations(
      with.job, {.stl = with.stl, .machine = with.machine, .operation = with.operation});
  if (!loaded) return planned;
  planned.placing = placing_of_operations(*loaded);
  planned.scene = scene_of(*loaded, with.stl, with.machine);
  return planned;
}

}  // namespace tiltfeed::desk
