#include "daemon/shop/shop_plan_layout.h"

namespace tiltfeed::daemon {

namespace {

/// The version with which a machine would plan for another now.
constexpr const char* kPlansColumn =
    "ALTER TABLE tiltfeed.machines ADD COLUMN plans text NOT NULL DEFAULT ''";
constexpr const char* kPlansOffered =
    "CREATE INDEX machines_plan ON tiltfeed.machines (plans) WHERE plans <> ''";

/// Each taking raises `token`: what an earlier taker still says does not count.
constexpr const char* kPlansTable = R"sql(CREATE TABLE tiltfeed.plans (
  id uuid PRIMARY KEY,
  number bigint GENERATED ALWAYS AS IDENTITY UNIQUE,
  asker uuid NOT NULL,
  name text NOT NULL CHECK (length(name) <= 200),
  version text NOT NULL CHECK (length(version) BETWEEN 1 AND 200),
  state text NOT NULL DEFAULT 'open' CHECK (state IN ('open', 'taken', 'done', 'failed')),
  helper uuid,
  token bigint NOT NULL DEFAULT 0,
  tries integer NOT NULL DEFAULT 0,
  lease timestamptz,
  percent integer NOT NULL DEFAULT 0 CHECK (percent BETWEEN 0 AND 100),
  stage text NOT NULL DEFAULT '' CHECK (length(stage) <= 100),
  note text NOT NULL DEFAULT '' CHECK (length(note) <= 500),
  planned_by text NOT NULL DEFAULT '' CHECK (length(planned_by) <= 200),
  planned_from text NOT NULL DEFAULT '' CHECK (length(planned_from) <= 200),
  asked timestamptz NOT NULL DEFAULT now(),
  changed timestamptz NOT NULL DEFAULT now()))sql";

/// Under token 0 what it is planned from, else what the taker of that token made.
constexpr const char* kPlanFilesTable = R"sql(CREATE TABLE tiltfeed.plan_files (
  plan uuid NOT NULL REFERENCES tiltfeed.plans ON DELETE CASCADE,
  token bigint NOT NULL,
  file smallint NOT NULL CHECK (file BETWEEN 0 AND 6),
  sha256 text NOT NULL CHECK (sha256 ~ '^[0-9a-f]{64}$'),
  bytes bigint NOT NULL CHECK (bytes BETWEEN 1 AND 268435456),
  PRIMARY KEY (plan, token, file)))sql";

constexpr const char* kPlanPiecesTable = R"sql(CREATE TABLE tiltfeed.plan_pieces (
  plan uuid NOT NULL,
  token bigint NOT NULL,
  file smallint NOT NULL,
  piece integer NOT NULL CHECK (piece BETWEEN 0 AND 1023),
  bytes bytea NOT NULL CHECK (octet_length(bytes) BETWEEN 1 AND 262144),
  PRIMARY KEY (plan, token, file, piece),
  FOREIGN KEY (plan, token, file) REFERENCES tiltfeed.plan_files ON DELETE CASCADE))sql";

}  // namespace

const std::vector<std::string>& shop_plan_layout() {
  static const std::vector<std::string> statements = {
      kPlansColumn,    kPlansOffered,    kPlansTable, "CREATE INDEX plans_asker ON tiltfeed.plans (asker)",
      kPlanFilesTable, kPlanPiecesTable,
  };
  return statements;
}

}  // namespace tiltfeed::daemon
