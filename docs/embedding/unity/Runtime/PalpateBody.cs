// A soft body in a scene: shows the asset's surface and moves it under the tools. MIT licence.
using System.Collections.Generic;
using UnityEngine;
using UnityEngine.Rendering;

[RequireComponent(typeof(MeshFilter))]
public sealed unsafe class PalpateBody : MonoBehaviour
{
    [Tooltip("A .palp of the project")] public PalpateAsset asset;
    [Tooltip("A mesh to draw in place of the surface; none: the surface")] public PalpateVisual visual;

    readonly Dictionary<PalpateTool, float[]> moved = new Dictionary<PalpateTool, float[]>();
    Vector3[] atRest, shown;
    float[] sum;
    Mesh mesh;

    public PalpateEngine Engine { get { return asset.Engine; } }

    public void OnEnable()
    {
        if ((transform.lossyScale - Vector3.one).magnitude > 1e-4f)
            Debug.LogWarning("Palpate: a body is not scaled, its forces belong to its size", this);
        Palpate.Mesh surface = Engine.Mesh;
        atRest = new Vector3[surface.Vertices];
        for (int v = 0; v < atRest.Length; ++v)
            atRest[v] = PalpateAxes.ToUnity(surface.OriginM[0] + surface.VertexM[3 * v],
                                            surface.OriginM[1] + surface.VertexM[3 * v + 1],
                                            surface.OriginM[2] + surface.VertexM[3 * v + 2]);
        sum = new float[3 * surface.Vertices];
        if (visual != null) visual.Hang(this);
        // Unity's front is clockwise.
        int[] corners = new int[3 * surface.Triangles];
        for (int c = 0; c < corners.Length; ++c) corners[c] = surface.Triangle[c / 3 * 3 + 2 - c % 3];
        shown = (Vector3[])atRest.Clone();
        mesh = new Mesh { indexFormat = IndexFormat.UInt32, vertices = shown, triangles = corners };
        mesh.RecalculateNormals();
        mesh.RecalculateBounds();
        GetComponent<MeshFilter>().sharedMesh = mesh;
    }

    public void OnDisable() { Destroy(mesh); }

    internal void Attach(PalpateTool tool) { moved[tool] = new float[3 * Engine.Info.Vertices]; }
    internal void Detach(PalpateTool tool) { moved.Remove(tool); }

    public void LateUpdate()
    {
        if (Engine.Info.HasShape == 0) return;
        bool isNew = false;
        foreach (KeyValuePair<PalpateTool, float[]> tool in moved)
            isNew |= tool.Key.Contact.Deform(0, atRest.Length, tool.Value);
        if (!isNew) return;
        System.Array.Clear(sum, 0, sum.Length);
        foreach (float[] by in moved.Values) // of tools by themselves: a sum, an approximation
            for (int i = 0; i < sum.Length; ++i) sum[i] += by[i];
        for (int v = 0; v < shown.Length; ++v)
            shown[v] = atRest[v] + PalpateAxes.ToUnity(sum[3 * v], sum[3 * v + 1], sum[3 * v + 2]);
        mesh.vertices = shown;
        mesh.RecalculateNormals();
        if (visual != null) visual.Show(sum);
    }
}
