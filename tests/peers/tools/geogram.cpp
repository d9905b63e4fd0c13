// Voronoi cells restricted to the mesh by geogram, on tetrahedra made by TetGen: the files of exchange.py. Called as
// `geogram INPUT OUTPUT RUNS`.

#include <geogram/basic/command_line.h>
#include <geogram/basic/command_line_args.h>
#include <geogram/basic/common.h>
#include <geogram/delaunay/delaunay.h>
#include <geogram/mesh/mesh.h>
#include <geogram/mesh/mesh_tetrahedralize.h>
#include <geogram/voronoi/RVD.h>
#include <geogram/voronoi/RVD_callback.h>
#include <geogram/voronoi/RVD_mesh_builder.h>

#include <chrono>
#include <cstdint>
#include <ctime>
#include <fstream>
#include <iterator>
#include <string>
#include <unordered_map>
#include <vector>

using namespace GEO;

static const double LIMIT_MS = 30e3;

static double milliseconds_since(std::chrono::steady_clock::time_point begun) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begun).count();
}

static std::vector<char> bytes(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return std::vector<char>(std::istreambuf_iterator<char>(file), {});
}

struct Fragment {
    std::unordered_map<int, uint32_t> index;
    std::vector<double> positions;
    std::vector<uint32_t> triangles;
};

// Faces of the cells on the border of the mesh or of another cell, joined by the symbolic identity of their vertices. Faces between
// two tetrahedra of one cell are left out.
class Cells : public RVDPolyhedronCallback {
public:
    explicit Cells(size_t sites) : fragments(sites) {
        set_simplify_internal_tet_facets(true);
    }

    void begin_facet(index_t, index_t) override {
        polygon_.clear();
    }

    void vertex(const double* geometry, const GEOGen::SymbolicVertex& symbol) override {
        Fragment& own = fragments[seed()];
        const int key = int(vertices_.find_or_create_vertex(seed(), symbol));
        const auto [entry, is_new] = own.index.insert({key, uint32_t(own.positions.size() / 3)});
        if (is_new)
            own.positions.insert(own.positions.end(), geometry, geometry + 3);
        polygon_.push_back(entry->second);
    }

    void end_facet() override {
        std::vector<uint32_t>& triangles = fragments[seed()].triangles;
        for (size_t i = 2; i < polygon_.size(); i++)
            triangles.insert(triangles.end(), {polygon_[0], polygon_[i - 1], polygon_[i]});
    }

    std::vector<Fragment> fragments;

private:
    RVDVertexMap vertices_;
    std::vector<uint32_t> polygon_;
};

template <typename T>
static void write(std::ofstream& file, const T* values, size_t count) {
    file.write(reinterpret_cast<const char*>(values), std::streamsize(count * sizeof(T)));
}

int main(int, char** arguments) {
    initialize(GEOGRAM_INSTALL_NONE);
    CmdLine::import_arg_group("standard");
    CmdLine::import_arg_group("algo");
    const std::string input = arguments[1], output = arguments[2];
    const std::vector<char> data = bytes(input + "/mesh.bin"), given = bytes(input + "/sites.bin");
    const uint32_t* header = reinterpret_cast<const uint32_t*>(data.data());
    const double* positions = reinterpret_cast<const double*>(data.data() + 12);
    const uint32_t* corners = reinterpret_cast<const uint32_t*>(data.data() + 12 + 24 * size_t(header[1]));
    const uint32_t site_count = *reinterpret_cast<const uint32_t*>(given.data());
    const std::vector<double> sites(reinterpret_cast<const double*>(given.data() + 4),
                                    reinterpret_cast<const double*>(given.data() + 4) + 3 * size_t(site_count));
    std::ofstream result(output + "/result.json");

    auto begun = std::chrono::steady_clock::now();
    Mesh mesh;
    mesh.vertices.set_dimension(3);
    mesh.vertices.create_vertices(header[1]);
    for (index_t v = 0; v < header[1]; v++)
        for (index_t axis = 0; axis < 3; axis++)
            mesh.vertices.point_ptr(v)[axis] = positions[3 * size_t(v) + axis];
    for (index_t t = 0; t < header[2]; t++)
        mesh.facets.create_triangle(corners[3 * size_t(t)], corners[3 * size_t(t) + 1], corners[3 * size_t(t) + 2]);
    mesh.facets.connect();
    if (!mesh_tetrahedralize(mesh, false, false)) {
        result << "{\"rejected\": \"mesh_tetrahedralize (TetGen) failed\"}";
        result.close();
        std::_Exit(0);
    }
    const double prepare_ms = milliseconds_since(begun);
    const std::string note = std::to_string(mesh.cells.nb()) + " tetrahedra by TetGen";

    std::string times, processor;
    double total = 0.0;
    const int runs = std::stoi(arguments[3]);
    for (int run = 0; run < runs && total < LIMIT_MS; run++) {
        const std::clock_t used = std::clock();
        begun = std::chrono::steady_clock::now();
        Delaunay_var delaunay = Delaunay::create(3);
        delaunay->set_vertices(site_count, sites.data());
        RestrictedVoronoiDiagram_var diagram = RestrictedVoronoiDiagram::create(delaunay, &mesh);
        diagram->set_volumetric(true);
        Cells cells(site_count);
        diagram->for_each_polyhedron(cells, true, true, false);
        const double passed = milliseconds_since(begun);
        total += passed;
        times += (run == 0 ? "" : ", ") + std::to_string(passed);
        processor += (run == 0 ? "" : ", ") + std::to_string(1e3 * double(std::clock() - used) / CLOCKS_PER_SEC);
        if (run > 0)
            continue;
        std::ofstream file(output + "/fragments.bin", std::ios::binary);
        const uint32_t count = uint32_t(cells.fragments.size());
        write(file, &count, 1);
        for (const Fragment& own : cells.fragments) {
            const uint32_t sizes[2] = {uint32_t(own.positions.size() / 3), uint32_t(own.triangles.size() / 3)};
            write(file, sizes, 2);
            write(file, own.positions.data(), own.positions.size());
            write(file, own.triangles.data(), own.triangles.size());
        }
    }
    result << "{\"times_ms\": [" << times << "], \"cpu_ms\": [" << processor << "], \"prepare_ms\": " << prepare_ms << ", \"note\": \"" << note << "\"}";
    result.close();
    std::_Exit(0);
}
