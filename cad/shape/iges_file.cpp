#include "cad/shape/iges_file.h"

#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepLib.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <IGESCAFControl_Reader.hxx>
#include <IGESData_GlobalSection.hxx>
#include <IGESData_IGESEntity.hxx>
#include <IGESData_IGESModel.hxx>
#include <Interface_Check.hxx>
#include <Standard_Failure.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_DataMapOfShapeInteger.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Solid.hxx>
#include <TransferBRep.hxx>
#include <Transfer_Binder.hxx>
#include <Transfer_TransientProcess.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>

#include "cad/shape/document.h"
#include "cad/shape/document_bodies.h"
#include "cad/shape/last_words.h"
#include "cad/text/iges_text.h"

namespace tiltfeed::cad {
namespace {

constexpr int kTrimmedSurface = 144, kBoundedSurface = 143;

/// The unit flag of the global section.
std::pair<const char*, double> iges_unit(int flag) {
  switch (flag) {
    case 1:
      return {"inch", 25.4};
    case 2:
      return {"millimetre", 1.0};
    case 4:
      return {"foot", 304.8};
    case 6:
      return {"metre", 1000.0};
    case 9:
      return {"micrometre", 1e-3};
    case 10:
      return {"centimetre", 10.0};
    default:
      return {"", 1.0};
  }
}

class IgesLoad {
 public:
  explicit IgesLoad(const std::string& path) : path_(path) {}

  Result<LoadedPart> run() {
    const Handle(TDocStd_Document) document = new_document();
    now_at("reading the entities of " + path_);
    reader_.SetNameMode(true), reader_.SetColorMode(true), reader_.SetLayerMode(false);
    reader_.SetReadVisible(true);
    if (reader_.ReadFile(path_.c_str()) != IFSelect_RetDone)
      return wrong("OpenCASCADE does not read this IGES file");
    model_ = Handle(IGESData_IGESModel)::DownCast(reader_.WS()->Model());
    if (model_.IsNull() || model_->NbEntities() == 0) return wrong("OpenCASCADE finds no entities in it");
    for (int i = 1; i <= model_->NbEntities(); ++i)
      if (model_->IsErrorEntity(i)) return refused(model_->Value(i), model_->Check(i, true));
    now_at("making shapes of " + path_);
    Handle(TDocStd_Document) filled = document;
    reader_.Transfer(filled);
    process_ = reader_.WS()->TransferReader()->TransientProcess();
    if (auto read = check_transfer(); !read) return tl::unexpected(read.error());
    note_sources();
    LoadedPart part;
    part.format = "IGES";
    const auto [unit, mm] = iges_unit(model_->GlobalSection().UnitFlag());
    part.unit = unit, part.unit_mm = mm;
    if (part.unit.empty())
      part.warnings.push_back(path_ +
                              ": the file's unit of length is one of its own; see that the size is right");
    part.bodies = sewn(bodies_of(*document, [this](const TopoDS_Shape& shape) { return source_of(shape); }),
                       part.warnings);
    if (part.bodies.empty()) return wrong("it holds no solid and no surface");
    return part;
  }

 private:
  tl::unexpected<Error> wrong(const std::string& what) const {
    return fail(Code::kInput, path_ + ": " + what + "; export the part again");
  }
  std::string name(const Handle(Standard_Transient) & entity) const {
    const Handle(IGESData_IGESEntity) iges = Handle(IGESData_IGESEntity)::DownCast(entity);
    return "D" + std::to_string(2 * model_->Number(entity) - 1) +
           (iges.IsNull() ? "" : " (type " + std::to_string(iges->TypeNumber()) + ")");
  }
  tl::unexpected<Error> refused(const Handle(Standard_Transient) & entity,
                                const Handle(Interface_Check) & check) const {
    std::string why = "cannot be read";
    if (!check.IsNull() && check->NbFails() > 0) why += ": " + std::string(check->CFail(1));
    return wrong(name(entity) + " " + why);
  }

  Result<void> check_transfer() const {
    for (int i = 1; i <= process_->NbMapped(); ++i) {
      const Handle(Transfer_Binder) binder = process_->MapItem(i);
      if (binder.IsNull() || binder->Check().IsNull() || !binder->Check()->HasFailed()) continue;
      if (!process_->Mapped(i).IsNull()) return refused(process_->Mapped(i), binder->Check());
    }
    for (int i = 1; i <= model_->NbEntities(); ++i) {
      const Handle(IGESData_IGESEntity) entity = Handle(IGESData_IGESEntity)::DownCast(model_->Value(i));
      if (entity.IsNull() ||
          (entity->TypeNumber() != kTrimmedSurface && entity->TypeNumber() != kBoundedSurface))
        continue;
      // What is not to be seen is not taken.
      if (entity->BlankStatus() != 0) continue;
      const Handle(Transfer_Binder) binder = process_->Find(entity);
      if (binder.IsNull() || TransferBRep::ShapeResult(binder).IsNull())
        return wrong(name(entity) + " gives no shape");
    }
    return {};
  }

  void note_sources() {
    for (int i = 1; i <= process_->NbMapped(); ++i) {
      const Handle(Transfer_Binder) binder = process_->MapItem(i);
      if (binder.IsNull()) continue;
      const TopoDS_Shape shape = TransferBRep::ShapeResult(binder);
      if (shape.IsNull()) continue;
      for (TopExp_Explorer e(shape, TopAbs_FACE); e.More(); e.Next()) note(e.Current(), i);
      note(shape, i);
    }
  }
  void note(const TopoDS_Shape& shape, int number) {
    const TopoDS_Shape key = shape.Located(TopLoc_Location()).Oriented(TopAbs_FORWARD);
    if (!sources_.IsBound(key)) sources_.Bind(key, number);
  }
  ShapeSource source_of(const TopoDS_Shape& shape) const {
    const TopoDS_Shape key = shape.Located(TopLoc_Location()).Oriented(TopAbs_FORWARD);
    if (!sources_.IsBound(key)) return {};
    const Handle(Standard_Transient) entity = process_->Mapped(sources_.Find(key));
    const Handle(IGESData_IGESEntity) iges = Handle(IGESData_IGESEntity)::DownCast(entity);
    std::string own;
    if (!iges.IsNull() && iges->HasName()) own = iges->NameValue()->ToCString();
    own.erase(0, own.find_first_not_of(' ') == own.npos ? own.size() : own.find_first_not_of(' '));
    return {name(entity), own};
  }

  /// All that is no solid becomes one body, or several that do not touch.
  std::vector<LoadedBody> sewn(std::vector<LoadedBody> bodies, std::vector<std::string>& warnings) {
    std::vector<LoadedBody> solids, loose;
    for (LoadedBody& body : bodies)
      (body.shape->ShapeType() == TopAbs_SOLID ? solids : loose).push_back(std::move(body));
    if (loose.empty()) return solids;
    now_at("sewing the faces of " + path_);
    BRepBuilderAPI_Sewing sewing(kSewn);
    for (const LoadedBody& body : loose) sewing.Add(*body.shape);
    sewing.Perform();
    TopTools_DataMapOfShapeInteger facts_of;
    std::vector<FaceFacts> facts;
    for (const LoadedBody& body : loose) {
      std::size_t i = 0;
      for (TopExp_Explorer e(*body.shape, TopAbs_FACE); e.More(); e.Next(), ++i) {
        const TopoDS_Shape now =
            sewing.IsModifiedSubShape(e.Current()) ? sewing.ModifiedSubShape(e.Current()) : e.Current();
        for (TopExp_Explorer f(now, TopAbs_FACE); f.More(); f.Next()) {
          const TopoDS_Shape key = f.Current().Oriented(TopAbs_FORWARD);
          if (!facts_of.IsBound(key)) facts_of.Bind(key, static_cast<int>(facts.size()));
        }
        facts.push_back(body.faces[i]);
      }
    }
    if (sewing.NbFreeEdges() > 0)
      warnings.push_back(path_ + ": " + std::to_string(sewing.NbFreeEdges()) +
                         " edges of its faces are open after sewing by " +
                         "0.01 mm; both sides count as surface there");
    add(sewing.SewedShape(), loose, facts_of, facts, solids);
    return solids;
  }

  static void add(const TopoDS_Shape& sewn, const std::vector<LoadedBody>& from,
                  const TopTools_DataMapOfShapeInteger& facts_of, const std::vector<FaceFacts>& facts,
                  std::vector<LoadedBody>& bodies) {
    std::vector<TopoDS_Shape> pieces;
    for (TopExp_Explorer e(sewn, TopAbs_SHELL); e.More(); e.Next()) {
      if (!BRep_Tool::IsClosed(e.Current())) {
        pieces.push_back(e.Current());
        continue;
      }
      TopoDS_Solid solid;
      BRep_Builder builder;
      builder.MakeSolid(solid);
      builder.Add(solid, e.Current());
      BRepLib::OrientClosedSolid(solid);
      pieces.push_back(solid);
    }
    for (TopExp_Explorer e(sewn, TopAbs_FACE, TopAbs_SHELL); e.More(); e.Next())
      pieces.push_back(e.Current());
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      LoadedBody body;
      body.name = from.size() == 1 ? from.front().name : "surfaces";
      if (pieces.size() > 1) body.name += ":" + std::to_string(i + 1);
      body.product = from.front().product;
      body.closed = pieces[i].ShapeType() == TopAbs_SOLID;
      for (TopExp_Explorer e(pieces[i], TopAbs_FACE); e.More(); e.Next()) {
        const TopoDS_Shape key = e.Current().Oriented(TopAbs_FORWARD);
        body.faces.push_back(facts_of.IsBound(key) ? facts[static_cast<std::size_t>(facts_of.Find(key))]
                                                   : FaceFacts{});
      }
      body.shape = std::make_unique<TopoDS_Shape>(pieces[i]);
      bodies.push_back(std::move(body));
    }
  }

  const std::string& path_;
  IGESCAFControl_Reader reader_;
  Handle(IGESData_IGESModel) model_;
  Handle(Transfer_TransientProcess) process_;
  TopTools_DataMapOfShapeInteger sources_;
};

}  // namespace

Result<LoadedPart> load_iges(const std::string& path) {
  const auto text = file_text(path);
  if (!text) return tl::unexpected(text.error());
  if (auto good = check_iges_text(*text, path); !good) return tl::unexpected(good.error());
  try {
    return IgesLoad(path).run();
  } catch (const Standard_Failure& failure) {
    return fail(Code::kInput, path + ": OpenCASCADE fails while " + at_now() + ": " +
                                  failure.GetMessageString() + "; export the part again");
  }
}

}  // namespace tiltfeed::cad
