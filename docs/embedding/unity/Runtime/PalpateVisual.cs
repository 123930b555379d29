// A mesh of one's own, with its textures, that a PalpateBody moves: the mesh of `palpate export --visual`,
// in the scene where it lies on the body. MIT licence.
using System;
using UnityEngine;

[RequireComponent(typeof(MeshFilter))]
public sealed class PalpateVisual : MonoBehaviour
{
    [Tooltip("How far a vertex may be from its place on the body [m]")] public float tolerance = 1e-4f;

    PalpateBody body;
    Mesh mesh;
    Vector3[] shown;
    int[] vertex; // of the mesh's file, of each vertex of Unity's

    Vector3 OnBody(Vector3 v) { return body.transform.InverseTransformPoint(transform.TransformPoint(v)); }

    /// Unity's importer splits vertices at seams and changes axes, so their places say which they are.
    internal void Hang(PalpateBody on)
    {
        body = on;
        mesh = GetComponent<MeshFilter>().mesh; // a copy of its own
        shown = mesh.vertices;
        vertex = new int[shown.Length];
        float[] place = body.Engine.PlaceVisual(null);
        int[] order = new int[place.Length / 3];
        float[] x = new float[order.Length];
        for (int i = 0; i < order.Length; ++i) { order[i] = i; x[i] = place[3 * i]; }
        Array.Sort(x, order);
        int missing = 0;
        for (int v = 0; v < shown.Length; ++v)
        {
            Vector3 at = OnBody(shown[v]);
            float least = tolerance;
            int low = Array.BinarySearch(x, at.x - tolerance);
            vertex[v] = -1;
            for (int k = low < 0 ? ~low : low; k < x.Length && x[k] <= at.x + tolerance; ++k)
            {
                float off = (At(place, order[k]) - at).magnitude;
                if (off > least) continue;
                least = off;
                vertex[v] = order[k];
            }
            if (vertex[v] < 0) ++missing;
        }
        if (missing > 0)
            Debug.LogWarning("Palpate: " + missing + " vertices of the mesh are not where `export --visual` had them", this);
    }

    /// displacement: of the surface [m], three floats a vertex.
    internal void Show(float[] displacement)
    {
        float[] place = body.Engine.PlaceVisual(displacement);
        for (int v = 0; v < shown.Length; ++v)
            if (vertex[v] >= 0)
                shown[v] = transform.InverseTransformPoint(body.transform.TransformPoint(At(place, vertex[v])));
        mesh.vertices = shown;
        mesh.RecalculateNormals();
    }

    static Vector3 At(float[] place, int i) { return PalpateAxes.ToUnity(place[3 * i], place[3 * i + 1], place[3 * i + 2]); }
}
