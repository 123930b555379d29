// Takes .palp files into a project, and says what is wrong with one that the engine refuses. MIT licence.
using System.IO;
using UnityEditor.AssetImporters;
using UnityEngine;

[ScriptedImporter(1, "palp")]
public sealed class PalpImporter : ScriptedImporter
{
    public override void OnImportAsset(AssetImportContext context)
    {
        PalpateAsset asset = ScriptableObject.CreateInstance<PalpateAsset>();
        asset.Content = File.ReadAllBytes(context.assetPath);
        try
        {
            asset.Engine.ToString();
        }
        catch (System.Exception refused) // the sentence, or that the native library is missing
        {
            context.LogImportError(context.assetPath + ": " + refused.Message);
        }
        context.AddObjectToAsset("asset", asset);
        context.SetMainObject(asset);
    }
}
