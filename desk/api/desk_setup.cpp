// The requests that set a job up: part, machine, forms, proposals, reach.

#include <charconv>
#include <nlohmann/json.hpp>

#include "config/machine_files.h"
#include "config/new_job.h"
#include "config/operations.h"
#include "desk/api/desk.h"
#include "desk/api/job_schema.h"
#include "desk/api/replies.h"
#include "desk/view/part_view.h"

namespace tiltfeed::desk {
namespace {

using nlohmann::json;

constexpr std::size_t kMostEdits = 200, kMostPicked = 1000;
constexpr double kMostSpread = 90.0;  // degrees

/// {"edits": [{"key", "value"}, ...]}; a value of null takes the key out. Nothing: the body is no such thing.
std::optional<std::vector<config::YamlEdit>> edits_in(const json& body) {
  if (!body.is_object() || !body.value("edits", json()).is_array()) return std::nullopt;
  std::vector<config::YamlEdit> edits;
  for (const json& edit : body["edits"]) {
    if (!edit.is_object() || !edit.value("key", json()).is_string() || edits.size() >= kMostEdits)
      return std::nullopt;
    const json value = edit.value("value", json());
    if (!value.is_null() && !value.is_string()) return std::nullopt;
    edits.push_back({edit["key"], value.is_null() ? std::nullopt : std::optional<std::string>(value)});
  }
  return edits;
}

Reply no_edits() { return refusal(400, "expected {\"edits\": [{\"key\": \"...\", \"value\": \"...\"}]}"); }

Reply asked(const Result<std::uint64_t>& id) {
  return id ? text_reply(json{{"id", *id}}.dump(), 202) : refused_by(id.error());
}

}  // namespace

Reply Desk::make_sample(const Request& request) {
  const auto name = text_in(request.body, "name");
  if (!name) return refusal(400, "expected {\"name\": \"tyre\"}, pin, sphere or handle");
  if (job_.is_open() && !job_.is_made_here())
    return refusal(409, "a job file is open, with a part of its own");
  if (const Result<void> made = part_.make(options_.maker, *name); !made) return refused_by(made.error());
  part_folder_.clear();
  return text_reply(part_.describe(), 202);
}

Reply Desk::machines(const Request&) {
  json list = json::array();
  for (const config::MachineFile& file : config::machine_files()) {
    const auto profile = config::parse_machine(file.text, file.name);
    if (!profile) continue;
    const MachineModel& m = profile->model;
    std::string axes = "XYZ";
    for (const RotaryAxis* rotary : {&m.tilt, &m.rotary})
      if (rotary->present) axes += rotary->letter;
    list.push_back({{"name", file.name}, {"axes", axes}});
  }
  return text_reply(list.dump());
}

Reply Desk::new_job(const Request& request) {
  const auto machine = text_in(request.body, "machine"), cutter = text_in(request.body, "cutter");
  if (!machine || !cutter) return refusal(400, "expected {\"machine\": \"...\", \"cutter\": \"ball:6\"}");
  if (part_.stl().empty()) return refusal(409, "there is no part that has been read");
  if (const Result<void> begun = job_.begin({part_.name(), part_folder_, part_.unit(), *machine, *cutter});
      !begun)
    return refused_by(begun.error());
  (void)job_changed();
  return text_reply(job_.describe(), 201);
}

Reply Desk::choose_machine(const Request& request) {
  const auto machine = text_in(request.body, "machine");
  if (!machine) return refusal(400, "expected {\"machine\": \"...\"}; GET machines has the names");
  if (const Result<void> chosen = job_.choose_machine(*machine); !chosen) return refused_by(chosen.error());
  return job_changed();
}

Reply Desk::machine_view(const Request&) { return machine_.view(); }

Reply Desk::job_file(const Request&) {
  if (!job_.is_open()) return refusal(409, "no job is open");
  Reply reply;
  reply.type = "text/plain; charset=utf-8";
  reply.body = job_.text();
  return reply;
}

Reply Desk::edit_job(const Request& request) {
  const auto edits = edits_in(json::parse(request.body, nullptr, false));
  if (!edits) return no_edits();
  if (const Result<void> done = job_.edit(*edits); !done) return refused_by(done.error());
  return job_changed();
}

Reply Desk::edit_operations(const Request& request) {
  const json body = json::parse(request.body, nullptr, false);
  const auto number = [&](const char* key) -> std::size_t {
    const json value = body.is_object() ? body.value(key, json()) : json();
    return value.is_number_unsigned() && value <= config::kMostOperations ? value.get<std::size_t>() : 0;
  };
  const std::string what = text_in(request.body, "do").value_or("");
  const std::size_t operation = number("number");
  const auto name = text_in(request.body, "name"), section = text_in(request.body, "section");
  Result<void> done;
  if (what == "copy" && name)
    done = job_.copy_operation(operation, *name);
  else if (what == "move" && number("to") > 0)
    done = job_.move_operation(operation, number("to"));
  else if (what == "remove")
    done = job_.take_out_operation(operation);
  else if ((what == "own" || what == "share") && section)
    done = job_.set_own(operation, *section, what == "own");
  else
    return refusal(
        400,
        "expected {\"do\": \"copy\", \"number\": 1, \"name\": \"...\"}, move with to, remove, or own "
        "and share with section");
  if (!done) return refused_by(done.error());
  return job_changed();
}

Reply Desk::schema(const Request& request) {
  if (!job_.is_open()) return refusal(409, "no job is open");
  std::size_t operation = 0;
  const std::string& stated = request.operation;
  const auto [end, error] = std::from_chars(stated.data(), stated.data() + stated.size(), operation);
  if (!stated.empty() && (error != std::errc{} || end != stated.data() + stated.size()))
    return refusal(400, "operation: expected its number in the list, from 1");
  const Result<std::string> keys = job_schema(job_.text(), operation);
  if (!keys) return refused_by(keys.error());
  return text_reply("{\"id\": " + std::to_string(job_.id()) + ", \"form\": " + *keys + "}");
}

Reply Desk::start_suggest(const Request& request) {
  if (!job_.is_right())
    return refusal(409, job_.is_open() ? "the job has errors; mend them first" : "no job is open");
  if (part_.stl().empty()) return refusal(409, "there is no part that has been read");
  const config::Job* const job = job_.operation(text_in(request.body, "operation").value_or(""));
  if (job == nullptr) return refusal(409, "there is no operation of this name");
  const SuggestInput input{part_.stl(), job_.unit(), job_.machine(), config::cutter_text(job->plan.cutter),
                           part_.id(),  job->bodies};
  if (const Result<void> begun = suggest_.start(input); !begun) return refused_by(begun.error());
  return text_reply(suggest_.describe(), 202);
}

Reply Desk::cancel_suggest(const Request&) {
  if (const Result<void> cancelled = suggest_.cancel(); !cancelled) return refused_by(cancelled.error());
  return text_reply(suggest_.describe(), 202);
}

AskedPart Desk::asked_part() const {
  return {part_.stl(), part_.id(), unit_length(part_.unit()).value_or(1.0), part_.choice().bodies,
          part_.choice().deviation};
}

Reply Desk::ask_reach(const Request& request) {
  const json body = json::parse(request.body, nullptr, false);
  const auto edits = edits_in(body);
  if (!edits || !body.value("exact", json(false)).is_boolean()) return no_edits();
  if (part_.stl().empty()) return refusal(409, "there is no part that has been read");
  const Result<std::string> text = job_.with(*edits);
  if (!text) return refused_by(text.error());
  const Result<std::string> whole = job_.whole(*text);
  if (!whole) return refused_by(whole.error());
  return asked(reach_.ask(asked_part(), {job_.id(), *whole, text_in(request.body, "operation").value_or("")},
                          job_.machine(), body.value("exact", false)));
}

Reply Desk::reach_map(const Request&) { return reach_.map(); }

Reply Desk::ask_fit(const Request& request) {
  const json body = json::parse(request.body, nullptr, false);
  const char* expected = "expected {\"facets\": [numbers of the file's facets], \"spread_deg\": 0 to 90}";
  if (!body.is_object() || !body.value("facets", json()).is_array()) return refusal(400, expected);
  std::vector<std::uint32_t> facets;
  for (const json& facet : body["facets"]) {
    if (!facet.is_number_unsigned() || facet > 0xFFFFFFFFu || facets.size() >= kMostPicked)
      return refusal(400, expected);
    facets.push_back(facet);
  }
  const json spread = body.value("spread_deg", json(0.0));
  if (facets.empty() || !spread.is_number() || spread < 0.0 || spread > kMostSpread)
    return refusal(400, expected);
  if (part_.stl().empty()) return refusal(409, "there is no part that has been read");
  return asked(reach_.fit(asked_part(), facets, spread));
}

}  // namespace tiltfeed::desk
