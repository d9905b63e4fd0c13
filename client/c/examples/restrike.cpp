// Breaks an object of a running shatterd, then the largest of its fragments. C++17; the guide explains how to build it ("Getting started").
//
//     again SERVICE OBJECT X,Y,Z JX,JY,JZ DEGREE
#include "shatter.h"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

namespace {

// Handles that free themselves.
template <auto Free> struct Freed {
    template <class Handle> void operator()(Handle *handle) const { Free(handle); }
};
using Service = std::unique_ptr<ShatterService, Freed<shatter_service_free>>;
using Object = std::unique_ptr<ShatterObject, Freed<shatter_object_free>>;
using Ticket = std::unique_ptr<ShatterTicket, Freed<shatter_ticket_free>>;
using Broken = std::unique_ptr<ShatterResult, Freed<shatter_result_free>>;

// Timeout of each call.
constexpr std::uint64_t patience_ms = 120000;

// An error of the library as an exception.
struct Refused : std::runtime_error {
    explicit Refused(const ShatterError &error) : std::runtime_error(error.message), error(error) {}
    ShatterError error;
};

// Calls `function` with the arguments and a `ShatterError`; throws on an error.
template <class Function, class... Arguments> void call(Function function, Arguments... arguments)
{
    ShatterError error;
    if (function(arguments..., &error) != SHATTER_CODE_OK) {
        throw Refused(error);
    }
}

Service connect(std::string_view name)
{
    ShatterService *service;
    call(shatter_connect, name.data(), name.size(), std::uint64_t{1000}, &service);
    return Service(service);
}

Object find(const Service &service, std::string_view name)
{
    ShatterObject *object;
    call(shatter_service_object, service.get(), name.data(), name.size(), std::uint64_t{1000}, &object);
    return Object(object);
}

Broken strike(const Object &object, const ShatterImpact &impact)
{
    ShatterTicket *sent;
    call(shatter_object_strike, object.get(), &impact, &sent);
    Ticket ticket(sent);
    ShatterResult *result;
    call(shatter_ticket_wait, ticket.get(), patience_ms, &result);
    return Broken(result);
}

ShatterSummary summary(const Broken &result)
{
    ShatterSummary summary;
    call(shatter_result_summary, result.get(), &summary);
    return summary;
}

ShatterFragment fragment(const Broken &result, std::uint32_t id)
{
    ShatterFragment fragment;
    call(shatter_result_fragment, result.get(), id, &fragment);
    return fragment;
}

// Whether every edge has exactly one opposite once the merge pairs are applied.
bool is_closed(const ShatterFragment &piece)
{
    std::vector<std::uint32_t> same(piece.vertex_count);
    std::iota(same.begin(), same.end(), 0U);
    auto root = [&same](std::uint32_t vertex) {
        while (same[vertex] != vertex) {
            vertex = same[vertex];
        }
        return vertex;
    };
    for (std::size_t i = 0; i < piece.merge_count; i++) {
        same[root(piece.merges[2 * i])] = root(piece.merges[2 * i + 1]);
    }
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (std::size_t i = 0; i + 2 < piece.index_count; i += 3) {
        for (std::size_t k = 0; k < 3; k++) {
            edges[{root(piece.indices[i + k]), root(piece.indices[i + (k + 1) % 3])}]++;
        }
    }
    for (const auto &[edge, times] : edges) {
        auto opposite = edges.find({edge.second, edge.first});
        if (times != 1 || opposite == edges.end() || opposite->second != 1) {
            return false;
        }
    }
    return !edges.empty();
}

// Checks and prints a result under `name`: closed fragments, hulls, bonds; returns the volume of all fragments, m^3.
double show(const char *name, const Broken &result)
{
    double volume_m3 = 0.0;
    std::uint32_t closed = 0, hulls = 0;
    const std::uint32_t count = summary(result).fragment_count;
    for (std::uint32_t id = 0; id < count; id++) {
        const ShatterFragment piece = fragment(result, id);
        if (piece.normals == nullptr || piece.uvs == nullptr || piece.attributes != nullptr) {
            throw std::logic_error("a section is missing, or was not requested");
        }
        ShatterHull hull;
        call(shatter_result_hull, result.get(), id, &hull);
        volume_m3 += piece.volume_m3;
        closed += is_closed(piece) ? 1 : 0;
        hulls += hull.vertex_count > 3 && hull.index_count <= 3 * 64 ? 1 : 0;
    }
    const ShatterBond *bonds;
    std::size_t bond_count;
    call(shatter_result_bonds, result.get(), &bonds, &bond_count);
    for (std::size_t i = 0; i < bond_count; i++) {
        if (bonds[i].fragments[0] >= count || bonds[i].area_m2 <= 0.0) {
            throw std::logic_error("a bond without an area or with an invalid fragment");
        }
    }
    std::printf("%s_fragments %u\n%s_closed %u\n%s_hulls %u\n", name, count, name, closed, name, hulls);
    std::printf("%s_bonds %zu\n%s_volume_m3 %.17g\n", name, bond_count, name, volume_m3);
    return volume_m3;
}

// A contact that pushes towards the center of a fragment, at its highest point.
ShatterContact on_top_of(const ShatterFragment &piece, double impulse_ns)
{
    ShatterContact contact{};
    float highest = piece.positions[1];
    for (std::size_t vertex = 0; vertex < piece.vertex_count; vertex++) {
        const float *position = piece.positions + 3 * vertex;
        if (vertex == 0 || position[1] > highest) {
            highest = position[1];
            for (int k = 0; k < 3; k++) {
                contact.point_m[k] = piece.center_m[k] + position[k];
            }
        }
    }
    contact.impulse_ns[1] = -impulse_ns;
    return contact;
}

bool vector(const char *text, double (&v)[3])
{
    return std::sscanf(text, "%lf,%lf,%lf", &v[0], &v[1], &v[2]) == 3;
}

void run(char **words, ShatterContact contact)
{
    const Service service = connect(words[1]);
    const Object object = find(service, words[2]);
    ShatterImpact impact{};
    impact.contacts = &contact;
    impact.contact_count = 1;
    impact.degree = SHATTER_DEGREE_SITES;
    impact.degree_sites = static_cast<std::uint32_t>(std::strtoul(words[5], nullptr, 10));
    impact.enable = SHATTER_EFFECT_NORMALS | SHATTER_EFFECT_UV | SHATTER_EFFECT_BONDS | SHATTER_EFFECT_HULLS;
    impact.keep = true;
    const Broken first = strike(object, impact);
    show("first", first);

    const ShatterSummary facts = summary(first);
    std::uint32_t largest = 0;
    for (std::uint32_t id = 1; id < facts.fragment_count; id++) {
        largest = fragment(first, id).volume_m3 > fragment(first, largest).volume_m3 ? id : largest;
    }
    const ShatterFragment parent = fragment(first, largest);
    contact = on_top_of(parent, 1.0);
    impact.degree_sites = 4;
    impact.from_handle = facts.handle;
    impact.from_fragment = largest;
    impact.keep = false;
    const Broken second = strike(object, impact);
    const double children_m3 = show("second", second);
    std::printf("parent_volume_m3 %.17g\nchildren_volume_m3 %.17g\n", parent.volume_m3, children_m3);
    call(shatter_service_release, service.get(), facts.handle, patience_ms);
    try {
        call(shatter_service_release, service.get(), facts.handle, patience_ms);
    } catch (const Refused &refused) {
        std::printf("released_twice %s\n", refused.error.name);
    }
}

} // namespace

int main(int count, char **words)
{
    ShatterContact contact{};
    if (count != 6 || !vector(words[3], contact.point_m) || !vector(words[4], contact.impulse_ns)) {
        std::fprintf(stderr, "usage: %s SERVICE OBJECT X,Y,Z JX,JY,JZ DEGREE\n", words[0]);
        return 2;
    }
    try {
        run(words, contact);
    } catch (const Refused &refused) {
        const ShatterError &why = refused.error;
        std::fprintf(stderr, "%s (%s, at `%s`)\n", why.message, why.name, why.at);
        return why.code == SHATTER_CODE_NO_DAEMON || why.code == SHATTER_CODE_LOST ? 4 : 3;
    } catch (const std::exception &error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 6;
    }
    return 0;
}
