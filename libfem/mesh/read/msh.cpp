// Gmsh MSH: version 1 (ASCII), 2.x and 4.1 (ASCII and binary of either byte order).
#include <algorithm>
#include <cstdlib>
#include <map>
#include <string>
#include <unordered_map>

#include "libfem/mesh/read/raw_mesh.hpp"

namespace palpate::mesh_read {
namespace {

// Element types of the Gmsh manual (MSH file format).
struct ElementType {
  std::int64_t number;
  std::size_t nodes;
  int dimension;
  std::string_view name;
};
constexpr ElementType kElementTypes[] = {
    {15, 1, 0, "point"},        {1, 2, 1, "line"},          {8, 3, 1, "line"},
    {26, 4, 1, "line"},         {27, 5, 1, "line"},         {28, 6, 1, "line"},
    {2, 3, 2, "triangle"},      {9, 6, 2, "triangle"},      {20, 9, 2, "triangle"},
    {21, 10, 2, "triangle"},    {22, 12, 2, "triangle"},    {23, 15, 2, "triangle"},
    {24, 15, 2, "triangle"},    {25, 21, 2, "triangle"},    {3, 4, 2, "quad"},
    {10, 9, 2, "quad"},         {16, 8, 2, "quad"},         {4, 4, 3, "tetrahedron"},
    {11, 10, 3, "tetrahedron"}, {29, 20, 3, "tetrahedron"}, {30, 35, 3, "tetrahedron"},
    {31, 56, 3, "tetrahedron"}, {5, 8, 3, "hexahedron"},    {12, 27, 3, "hexahedron"},
    {17, 20, 3, "hexahedron"},  {6, 6, 3, "prism"},         {13, 18, 3, "prism"},
    {18, 15, 3, "prism"},       {7, 5, 3, "pyramid"},       {14, 14, 3, "pyramid"},
    {19, 13, 3, "pyramid"},
};

const ElementType& element_type(std::int64_t number, const Cursor& file) {
  for (const ElementType& row : kElementTypes)
    if (row.number == number) return row;
  file.fail("element type " + std::to_string(number) + " is not known",
            "Mesh the volume with linear or quadratic tetrahedra.");
}

class MshFile {
 public:
  MshFile(Cursor& file, RawLabels* labels) : file_(file), labels_(labels) {}

  RawMesh read() {
    while (!file_.at_end()) {
      const std::string_view section = file_.word();
      if (section == "$MeshFormat")
        read_format();
      else if (section == "$NOD")
        read_nodes_2();
      else if (section == "$ELM")
        read_elements_1();
      else if (section == "$Nodes")
        version_ >= 4 ? read_nodes_4() : read_nodes_2();
      else if (section == "$Elements")
        version_ >= 4 ? read_elements_4() : read_elements_2();
      else if (section == "$PhysicalNames" && labels_ != nullptr)
        read_physical_names();
      else if (section == "$Entities" && labels_ != nullptr && version_ >= 4)
        read_entities();
      else if (section.starts_with('$'))
        skip_section(section);
      else
        file_.fail("expected a section that begins with '$'");
    }
    return std::move(mesh_);
  }

 private:
  // A number of one of the kinds that MSH writes in binary: int and size_t.
  std::int64_t small() { return file_.integer(NumberType::int32); }
  std::int64_t large() { return file_.integer(NumberType::uint64); }
  std::size_t least(std::size_t bytes) const { return data_ == Encoding::text ? 2 : bytes; }

  void read_format() {
    version_ = file_.real();
    if (version_ < 2 || version_ >= 5 || (version_ >= 3 && version_ != 4.1))
      file_.fail("this version of MSH is not supported", "Save it as MSH 4.1 or 2.2.");
    const bool is_binary = file_.integer() != 0;
    if (file_.integer() != 8)
      file_.fail("numbers are not of 8 bytes", "Save it as MSH 4.1 or 2.2.");
    file_.line();
    if (is_binary) {
      file_.encoding = Encoding::little_endian;
      if (small() != 1) {
        file_.encoding = Encoding::big_endian;
        file_.seek(file_.position() - 4);
        if (small() != 1) file_.fail("the byte order mark is not 1");
      }
      data_ = file_.encoding;
      file_.encoding = Encoding::text;
    }
    file_.expect("$EndMeshFormat");
  }

  void skip_section(std::string_view name) {
    const std::string end = "$End" + std::string(name.substr(1));
    const std::size_t at = file_.bytes().find(end, file_.position());
    if (at == std::string_view::npos) file_.fail("section is not closed by " + end);
    file_.seek(at + end.size());
  }

  void add_node(std::int64_t tag, const Vec3& point) {
    if (!index_.try_emplace(tag, mesh_.points.size()).second)
      file_.fail("node " + std::to_string(tag) + " is there twice");
    mesh_.points.push_back(point);
  }

  void read_nodes_2() {
    const std::int64_t number = file_.integer();
    file_.line();
    const std::size_t nodes =
        file_.checked_count(number, data_ == Encoding::text ? 7 : 28, "nodes");
    file_.encoding = data_;
    for (std::size_t n = 0; n < nodes; ++n) {
      const std::int64_t tag = small();
      add_node(tag, file_.position_3d());
    }
    end_section();
  }

  void read_nodes_4() {
    file_.line();
    file_.encoding = data_;
    const std::int64_t blocks = large();
    for (int i = 0; i < 3; ++i) large();  // nodes in all, least and largest tag
    std::vector<std::int64_t> tags;
    for (std::int64_t b = 0; b < blocks; ++b) {
      const std::int64_t dimension = small();
      small();  // tag of the entity
      const bool is_parametric = small() != 0;
      const std::int64_t parameters = is_parametric ? std::clamp<std::int64_t>(dimension, 0, 3) : 0;
      tags.resize(file_.count(NumberType::uint64, least(32), "nodes"));
      for (std::int64_t& tag : tags) tag = large();
      for (const std::int64_t tag : tags) {
        add_node(tag, file_.position_3d());
        for (std::int64_t i = 0; i < parameters; ++i) file_.real();
      }
    }
    end_section();
  }

  // dimension tag "name", in text also where all else is binary.
  void read_physical_names() {
    const std::size_t names = file_.count(NumberType::int64, 6, "names");
    for (std::size_t i = 0; i < names; ++i) {
      const auto dimension = static_cast<int>(file_.integer());
      const std::int64_t tag = file_.integer();
      const std::string_view rest = file_.line();
      const std::size_t open = rest.find('"'), close = rest.rfind('"');
      if (open == std::string_view::npos || close == open)
        file_.fail("a physical name is not in quotes");
      physical_name_[{dimension, tag}] = rest.substr(open + 1, close - open - 1);
    }
    end_section();
  }

  // Reads the physical groups of each entity; its place and what bounds it are passed over.
  void read_entities() {
    file_.line();
    file_.encoding = data_;
    std::array<std::int64_t, 4> number;
    for (std::int64_t& n : number) n = large();
    for (int dimension = 0; dimension < 4; ++dimension)
      for (std::int64_t e = 0; e < number[dimension]; ++e) {
        const std::int64_t tag = small();
        for (int i = 0; i < (dimension == 0 ? 3 : 6); ++i) file_.real();
        auto& groups = physical_of_[{dimension, tag}];
        groups.resize(file_.count(NumberType::uint64, least(4), "physical tags"));
        for (std::int64_t& group : groups) group = small();
        if (dimension == 0) continue;
        const std::size_t around = file_.count(NumberType::uint64, least(4), "bounding entities");
        for (std::size_t i = 0; i < around; ++i) small();
      }
    end_section();
  }

  // The next cell of the labels, in its physical groups; 0 stands for none.
  void label(const ElementType& type, std::span<const std::int64_t> groups) {
    if (labels_ == nullptr) return;
    for (const std::int64_t tag : groups) {
      if (tag == 0) continue;
      const auto name = physical_name_.find({type.dimension, std::abs(tag)});
      labels_
          ->group(name != physical_name_.end() ? name->second : std::to_string(std::abs(tag)),
                  type.dimension)
          .cells.push_back(labels_->cells);
    }
    ++labels_->cells;
  }

  std::int64_t index_of(std::int64_t tag, std::int64_t element) const {
    const auto at = index_.find(tag);
    if (at == index_.end())
      file_.fail("element " + std::to_string(element) + " uses node " + std::to_string(tag) +
                 ", which is not there");
    return static_cast<std::int64_t>(at->second);
  }

  void add_element(std::int64_t id, const ElementType& type, std::span<const std::int64_t> tags,
                   std::span<const std::int64_t> groups) {
    label(type, groups);
    if (type.dimension < 3) {
      ++mesh_.ignored_elements;
      if (labels_ == nullptr || type.name != "triangle") return;
      auto& face = labels_->faces.emplace_back();
      for (std::size_t k = 0; k < 3; ++k)
        face[k] = static_cast<std::int32_t>(index_of(tags[k], id));
      labels_->face_cell.push_back(labels_->cells - 1);
      return;
    }
    if (type.name != "tetrahedron") fail_not_tets(file_, type.name);
    std::array<std::int64_t, 4> corners;
    for (std::size_t i = 0; i < 4; ++i) corners[i] = index_of(tags[i], id);
    add_tet(mesh_, corners, id, file_);
    if (labels_ != nullptr) labels_->cell.push_back(labels_->cells - 1);
  }

  void read_elements_1() {
    const std::size_t elements = file_.count(NumberType::int64, 12, "elements");
    std::vector<std::int64_t> tags;
    for (std::size_t e = 0; e < elements; ++e) {
      const std::int64_t id = file_.integer();
      const ElementType& type = element_type(file_.integer(), file_);
      const std::int64_t group = file_.integer();
      file_.integer();  // elementary region
      tags.resize(type.nodes);
      if (file_.integer() != static_cast<std::int64_t>(type.nodes))
        file_.fail("element " + std::to_string(id) + " has a wrong number of nodes");
      for (std::int64_t& tag : tags) tag = file_.integer();
      add_element(id, type, tags, {&group, 1});
    }
    end_section();
  }

  // In text each element has a type and tags of its own; in binary a header is shared by a run.
  void read_elements_2() {
    const std::int64_t number = file_.integer();
    file_.line();
    const std::size_t elements = file_.checked_count(number, least(8), "elements");
    file_.encoding = data_;
    const bool is_binary = data_ != Encoding::text;
    std::vector<std::int64_t> tags;
    for (std::size_t e = 0; e < elements;) {
      std::int64_t id = is_binary ? 0 : small();
      const ElementType& type = element_type(small(), file_);
      const std::size_t run = is_binary ? file_.count(NumberType::int32, 8, "elements") : 1;
      const std::size_t labels = file_.count(NumberType::int32, least(0), "element tags");
      if (run == 0 || run > elements - e)
        file_.fail("a run of elements is longer than its section");
      tags.resize(type.nodes);
      for (std::size_t i = 0; i < run; ++i) {
        if (is_binary) id = small();
        std::int64_t group = 0;  // the first of the element's tags
        for (std::size_t t = 0; t < labels; ++t)
          if (const std::int64_t tag = small(); t == 0) group = tag;
        for (std::int64_t& tag : tags) tag = small();
        add_element(id, type, tags, {&group, 1});
      }
      e += run;
    }
    end_section();
  }

  void read_elements_4() {
    file_.line();
    file_.encoding = data_;
    const std::int64_t blocks = large();
    for (int i = 0; i < 3; ++i) large();  // elements in all, least and largest tag
    std::vector<std::int64_t> tags;
    for (std::int64_t b = 0; b < blocks; ++b) {
      const auto dimension = static_cast<int>(small());
      const std::int64_t entity = small();
      const auto groups = physical_of_.find({dimension, entity});
      const ElementType& type = element_type(small(), file_);
      tags.resize(type.nodes);
      const std::size_t elements = file_.count(NumberType::uint64, least(16), "elements");
      for (std::size_t e = 0; e < elements; ++e) {
        const std::int64_t id = large();
        for (std::int64_t& tag : tags) tag = large();
        add_element(id, type, tags,
                    groups != physical_of_.end() ? std::span<const std::int64_t>(groups->second)
                                                 : std::span<const std::int64_t>());
      }
    }
    end_section();
  }

  void end_section() {
    file_.encoding = Encoding::text;
    const std::string_view word = file_.word();
    if (!word.starts_with("$E")) file_.fail("a section is longer or shorter than it announces");
  }

  Cursor& file_;
  RawLabels* labels_;
  std::map<std::pair<int, std::int64_t>, std::string> physical_name_;  // by dimension and tag
  std::map<std::pair<int, std::int64_t>, std::vector<std::int64_t>> physical_of_;  // of entities
  double version_ = 1;
  Encoding data_ = Encoding::text;
  RawMesh mesh_;
  std::unordered_map<std::int64_t, std::size_t> index_;  // of each node tag
};

}  // namespace

RawMesh read_msh(Cursor& file, RawLabels* labels) {
  if (!file.bytes().starts_with("$")) file.fail("does not begin with $MeshFormat or $NOD");
  return MshFile(file, labels).read();
}

}  // namespace palpate::mesh_read
