#include "cad/shape/step_file.h"

#include <Interface_Check.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <STEPConstruct_ExternRefs.hxx>
#include <Standard_Failure.hxx>
#include <StepBasic_ProductDefinition.hxx>
#include <StepData_StepModel.hxx>
#include <StepRepr_RepresentationItem.hxx>
#include <StepShape_FaceSurface.hxx>
#include <TColStd_SequenceOfAsciiString.hxx>
#include <TDocStd_Document.hxx>
#include <TopTools_DataMapOfShapeInteger.hxx>
#include <TopoDS_Shape.hxx>
#include <TransferBRep.hxx>
#include <Transfer_Binder.hxx>
#include <Transfer_TransientProcess.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>
#include <algorithm>
#include <map>

#include "cad/shape/document.h"
#include "cad/shape/document_bodies.h"
#include "cad/shape/last_words.h"
#include "cad/text/step_text.h"

namespace tiltfeed::cad {
namespace {

Transfer_TransientProcess* transferred = nullptr;  // while a file is transferred, for the last words
StepData_StepModel* model_of_transfer = nullptr;
const StepEntities* entities_of_transfer = nullptr;
std::string last_entity;

/// Colours, drawings, tolerances, approvals: what is wrong with them does not touch the shape.
bool beside_shape(const Handle(Standard_Transient) & entity) {
  const std::string type = entity->DynamicType()->Name();
  for (const char* beside : {"StepVisual_", "StepDimTol_", "StepKinematics_", "StepFEA_", "StepElement_",
                             "StepAP203_", "StepAP214_", "StepAP242_"})
    if (type.starts_with(beside)) return true;
  return false;
}

/// In a process that ends: any of it may fail.
const char* last_transferred() {
  if (transferred == nullptr || transferred->NbMapped() == 0) return nullptr;
  const int number = model_of_transfer->IdentLabel(transferred->Mapped(transferred->NbMapped()));
  last_entity = entities_of_transfer->name(static_cast<std::uint64_t>(number));
  return last_entity.c_str();
}

class StepLoad {
 public:
  StepLoad(const std::string& path, const StepEntities& entities) : path_(path), entities_(entities) {}

  Result<LoadedPart> run() {
    const Handle(TDocStd_Document) document = new_document();
    now_at("reading the entities of " + path_);
    reader_.SetNameMode(true), reader_.SetColorMode(true), reader_.SetLayerMode(false);
    if (reader_.ReadFile(path_.c_str()) != IFSelect_RetDone)
      return wrong("OpenCASCADE does not read this STEP file");
    model_ = Handle(StepData_StepModel)::DownCast(reader_.Reader().WS()->Model());
    if (model_.IsNull()) return wrong("OpenCASCADE finds no entities in it");
    for (int i = 1; i <= model_->NbEntities(); ++i)
      if (model_->IsErrorEntity(i) || model_->Check(i, true)->HasFailed()) {
        if (!beside_shape(model_->Value(i))) return refused(model_->Value(i), model_->Check(i, true));
        warnings_.push_back(refusal(model_->Value(i), model_->Check(i, true)) +
                            "; the shape does not need it");
      }
    if (auto whole = check_whole(); !whole) return tl::unexpected(whole.error());
    transfer(document);
    if (auto read = check_transfer(); !read) return tl::unexpected(read.error());
    LoadedPart part;
    part.warnings = std::move(warnings_);
    part.format = "STEP";
    if (!entities_.schema.empty()) part.format += " (" + entities_.schema + ")";
    read_unit(part);
    note_sources();
    part.bodies = bodies_of(*document, [this](const TopoDS_Shape& shape) { return source_of(shape); });
    if (part.bodies.empty()) return wrong("it holds no solid and no surface");
    return part;
  }

 private:
  tl::unexpected<Error> wrong(const std::string& what) const {
    return fail(Code::kInput, path_ + ": " + what + "; export the part again");
  }
  std::string name(const Handle(Standard_Transient) & entity) const {
    return entities_.name(static_cast<std::uint64_t>(std::max(0, model_->IdentLabel(entity))));
  }
  std::string refusal(const Handle(Standard_Transient) & entity,
                      const Handle(Interface_Check) & check) const {
    std::string why = "cannot be read";
    if (check->NbFails() > 0) why += ": " + std::string(check->CFail(1));
    return name(entity) + " " + why;
  }
  tl::unexpected<Error> refused(const Handle(Standard_Transient) & entity,
                                const Handle(Interface_Check) & check) const {
    return wrong(refusal(entity, check));
  }

  /// OpenCASCADE would open each of these by itself, with whatever path: who sends a part must not choose
  /// files of this computer.
  Result<void> check_whole() const {
    STEPConstruct_ExternRefs others(reader_.Reader().WS());
    others.LoadExternRefs();
    for (int i = 1; i <= others.NbExternRefs(); ++i) {
      const char* const file = others.FileName(i);
      if (file == nullptr || *file == '\0') continue;
      const Handle(StepBasic_ProductDefinition) product = others.ProdDef(i);
      return fail(Code::kInput, path_ + ": " + (product.IsNull() ? "a product" : name(product)) +
                                    " refers to another file, \"" + file +
                                    "\", which is not read: export the part as one file");
    }
    return {};
  }

  void transfer(Handle(TDocStd_Document) document) {
    now_at("making shapes of " + path_);
    process_ = reader_.Reader().WS()->TransferReader()->TransientProcess();
    transferred = process_.get(), model_of_transfer = model_.get(), entities_of_transfer = &entities_;
    ask_in_fault(last_transferred);
    reader_.Transfer(document);
    transferred = nullptr;
    process_ = reader_.Reader().WS()->TransferReader()->TransientProcess();
  }

  /// What OpenCASCADE calls done may lack faces.
  Result<void> check_transfer() const {
    for (int i = 1; i <= process_->NbMapped(); ++i) {
      const Handle(Transfer_Binder) binder = process_->MapItem(i);
      if (binder.IsNull() || binder->Check().IsNull() || !binder->Check()->HasFailed()) continue;
      if (!process_->Mapped(i).IsNull() && !beside_shape(process_->Mapped(i)))
        return refused(process_->Mapped(i), binder->Check());
    }
    for (int i = 1; i <= model_->NbEntities(); ++i) {
      const Handle(Standard_Transient) entity = model_->Value(i);
      if (!entity->IsKind(STANDARD_TYPE(StepShape_FaceSurface))) continue;
      const Handle(Transfer_Binder) binder = process_->Find(entity);
      if (binder.IsNull() || TransferBRep::ShapeResult(binder).IsNull())
        return wrong(name(entity) + " gives no shape");
    }
    return {};
  }

  void read_unit(LoadedPart& part) {
    TColStd_SequenceOfAsciiString lengths, angles, solid_angles;
    reader_.ChangeReader().FileUnits(lengths, angles, solid_angles);
    if (lengths.IsEmpty()) {
      part.warnings.push_back(path_ + ": the file states no unit of length; taken as mm");
      return;
    }
    part.unit = lengths.First().ToCString();
    static const std::map<std::string, double> known = {
        {"millimetre", 1.0}, {"centimetre", 10.0}, {"metre", 1000.0},   {"inch", 25.4},
        {"INCH", 25.4},      {"foot", 304.8},      {"micrometre", 1e-3}};
    if (const auto at = known.find(part.unit); at != known.end()) part.unit_mm = at->second;
    for (int i = 2; i <= lengths.Length(); ++i)
      if (lengths.Value(i) != lengths.First()) {
        part.warnings.push_back(path_ + ": the file has lengths in " + part.unit + " and in " +
                                lengths.Value(i).ToCString() + "; each is taken in its own unit");
        break;
      }
  }

  void note_sources() {
    for (int i = 1; i <= process_->NbMapped(); ++i) {
      const Handle(Transfer_Binder) binder = process_->MapItem(i);
      const Handle(StepRepr_RepresentationItem) item =
          Handle(StepRepr_RepresentationItem)::DownCast(process_->Mapped(i));
      if (binder.IsNull() || item.IsNull()) continue;
      const TopoDS_Shape shape = TransferBRep::ShapeResult(binder);
      if (shape.IsNull()) continue;
      const TopoDS_Shape key = shape.Located(TopLoc_Location()).Oriented(TopAbs_FORWARD);
      if (!sources_.IsBound(key)) sources_.Bind(key, i);
    }
  }

  ShapeSource source_of(const TopoDS_Shape& shape) const {
    const TopoDS_Shape key = shape.Located(TopLoc_Location()).Oriented(TopAbs_FORWARD);
    if (!sources_.IsBound(key)) return {};
    const Handle(Standard_Transient) entity = process_->Mapped(sources_.Find(key));
    const Handle(StepRepr_RepresentationItem) item = Handle(StepRepr_RepresentationItem)::DownCast(entity);
    // Writers put NONE where they have no name.
    std::string own = item->Name().IsNull() ? "" : item->Name()->ToCString();
    if (own == "NONE") own.clear();
    return {name(entity), own};
  }

  const std::string& path_;
  const StepEntities& entities_;
  STEPCAFControl_Reader reader_;
  Handle(StepData_StepModel) model_;
  Handle(Transfer_TransientProcess) process_;
  TopTools_DataMapOfShapeInteger sources_;
  std::vector<std::string> warnings_;
};

}  // namespace

Result<LoadedPart> load_step(const std::string& path) {
  const auto text = file_text(path);
  if (!text) return tl::unexpected(text.error());
  const auto entities = check_step_text(*text, path);
  if (!entities) return tl::unexpected(entities.error());
  try {
    return StepLoad(path, *entities).run();
  } catch (const Standard_Failure& failure) {
    const char* last = last_transferred();
    return fail(Code::kInput, path + ": OpenCASCADE fails while " + at_now() +
                                  (last ? std::string(", after ") + last : "") + ": " +
                                  failure.GetMessageString() + "; export the part again");
  }
}

}  // namespace tiltfeed::cad
