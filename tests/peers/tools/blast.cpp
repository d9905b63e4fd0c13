// Fractures the mesh by NVIDIA Blast's authoring library: the files of exchange.py. Called as `blast INPUT OUTPUT RUNS`.

#include "NvBlastExtAuthoring.h"
#include "NvBlastExtAuthoringFractureTool.h"
#include "NvBlastExtAuthoringMesh.h"

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

using namespace Nv::Blast;

static const double LIMIT_MS = 30e3;

static std::vector<char> bytes(const std::string& path)
{
    std::ifstream file(path, std::ios::binary);
    return std::vector<char>(std::istreambuf_iterator<char>(file), {});
}

static std::vector<NvcVec3> points(const char* data, uint32_t count)
{
    const double* values = reinterpret_cast<const double*>(data);
    std::vector<NvcVec3> all(count);
    for (uint32_t i = 0; i < count; i++)
        all[i] = { float(values[3 * i]), float(values[3 * i + 1]), float(values[3 * i + 2]) };
    return all;
}

static void write(std::ofstream& file, uint32_t value)
{
    file.write(reinterpret_cast<const char*>(&value), sizeof value);
}

static void writeVertex(std::ofstream& file, const Vertex& vertex)
{
    const double values[3] = { vertex.p.x, vertex.p.y, vertex.p.z };
    file.write(reinterpret_cast<const char*>(values), sizeof values);
}

int main(int, char** arguments)
{
    const std::string input = arguments[1], output = arguments[2];
    const std::vector<char> mesh = bytes(input + "/mesh.bin"), given = bytes(input + "/sites.bin");
    const uint32_t* header = reinterpret_cast<const uint32_t*>(mesh.data());
    const uint32_t vertexCount = header[1], triangleCount = header[2];
    const std::vector<NvcVec3> positions = points(mesh.data() + 12, vertexCount);
    const char* indices = mesh.data() + 12 + 24 * size_t(vertexCount);
    const std::vector<uint32_t> corners(reinterpret_cast<const uint32_t*>(indices),
                                        reinterpret_cast<const uint32_t*>(indices) + 3 * size_t(triangleCount));
    const uint32_t siteCount = *reinterpret_cast<const uint32_t*>(given.data());
    const std::vector<NvcVec3> sites = points(given.data() + 4, siteCount);
    const std::vector<NvcVec3> normals(vertexCount, NvcVec3{ 0, 0, 1 });
    const std::vector<NvcVec2> uv(vertexCount, NvcVec2{ 0, 0 });

    std::ofstream result(output + "/result.json");
    std::string times, processor;
    double total = 0.0;
    const int runs = std::atoi(arguments[3]);
    for (int run = 0; run < runs && total < LIMIT_MS; run++)
    {
        const std::clock_t used = std::clock();
        const auto begun = std::chrono::steady_clock::now();
        Mesh* whole = NvBlastExtAuthoringCreateMesh(positions.data(), normals.data(), uv.data(), vertexCount, corners.data(),
                                                    uint32_t(corners.size()));
        FractureTool* tool = NvBlastExtAuthoringCreateFractureTool();
        if (whole == nullptr || !tool->setSourceMeshes(&whole, 1) || tool->voronoiFracturing(0, siteCount, sites.data(), false) != 0)
        {
            result << "{\"rejected\": \"voronoiFracturing returned an error\"}";
            return 0;
        }
        tool->finalizeFracturing();
        std::vector<std::pair<Triangle*, uint32_t>> fragments;
        for (uint32_t chunk = 0; chunk < tool->getChunkCount(); chunk++)
        {
            Triangle* triangles = nullptr;
            const uint32_t count = tool->getChunkInfo(int32_t(chunk)).isLeaf ? tool->getBaseMesh(int32_t(chunk), triangles) : 0;
            if (count > 0)
                fragments.push_back({ triangles, count });
        }
        const std::chrono::duration<double, std::milli> passed = std::chrono::steady_clock::now() - begun;
        total += passed.count();
        times += (run == 0 ? "" : ", ") + std::to_string(passed.count());
        processor += (run == 0 ? "" : ", ") + std::to_string(1e3 * double(std::clock() - used) / CLOCKS_PER_SEC);
        if (run == 0)
        {
            std::ofstream file(output + "/fragments.bin", std::ios::binary);
            write(file, uint32_t(fragments.size()));
            for (const auto& [triangles, count] : fragments)
            {
                write(file, 3 * count);
                write(file, count);
                for (uint32_t i = 0; i < count; i++)
                    for (const Vertex* vertex : { &triangles[i].a, &triangles[i].b, &triangles[i].c })
                        writeVertex(file, *vertex);
                for (uint32_t i = 0; i < 3 * count; i++)
                    write(file, i);
            }
        }
        tool->release();
        whole->release();
    }
    result << "{\"times_ms\": [" << times << "], \"cpu_ms\": [" << processor << "], \"prepare_ms\": 0, \"note\": \"\"}";
}
